// How much goes out before the peer has acknowledged it.
#include "gateway/outbox/flow_window.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <deque>

namespace arkmesh::gateway {
namespace {

using namespace std::chrono_literals;

// A path that takes `delay` each way and passes on `bytes_per_s`; the sender fills its window.
struct Path {
  std::chrono::microseconds delay;
  double bytes_per_s;
  FlowWindow window{FlowLimits{}};
  FlowWindow::Time now{};
  std::uint64_t sent = 0;
  FlowWindow::Time free_at{};
  std::deque<std::pair<FlowWindow::Time, std::uint64_t>> acks;

  // Returns the longest time that a byte needed to arrive in the second half of so long.
  std::chrono::duration<double> run(std::chrono::seconds length) {
    window.path_takes(2 * delay);
    std::chrono::duration<double> longest{0};
    const auto half = now + length / 2, end = now + length;
    for (; now < end; now += 1ms) {
      for (; !acks.empty() && acks.front().first <= now; acks.pop_front())
        CHECK(window.acknowledged(acks.front().second, now));
      while (window.room(now) > 0) {
        const std::size_t bytes = std::min<std::size_t>(window.room(now), 2000);
        sent += bytes;
        window.sent(bytes, now);
        free_at = std::max(free_at, now) +
                  std::chrono::microseconds(static_cast<long>(1e6 * static_cast<double>(bytes) / bytes_per_s));
        acks.emplace_back(free_at + 2 * delay, sent);
        if (now >= half) longest = std::max<std::chrono::duration<double>>(longest, free_at + delay - now);
      }
    }
    return longest;
  }
};

TEST_CASE("on a fast path the window opens, and stays shut for who does not need it") {
  // A long path of much room is used up to the limit; a sender that says little is given no more than it began with.
  Path path{.delay = 50ms, .bytes_per_s = 1e9};
  path.run(3s);
  CHECK(path.window.under_way() + path.window.room(path.now) == FlowLimits{}.bytes);
  Path quiet{.delay = 1ms, .bytes_per_s = 1e9};
  std::uint64_t total = 0;
  for (int i = 0; i < 100; ++i) {
    quiet.window.sent(1000, quiet.now);
    CHECK(quiet.window.acknowledged(total += 1000, quiet.now += 2ms));
  }
  CHECK(quiet.window.room(quiet.now) == FlowWindow::first_bytes);
}

TEST_CASE("a peer that may wait with its acknowledgements is not taken for a slow path") {
  // 60 kB a second, each three messages acknowledged 150 ms later: the window stays as it was. Without a word of that
  // it shuts, and what goes next waits.
  for (const auto waits : {0ms, 200ms}) {
    FlowWindow window{FlowLimits{}};
    FlowWindow::Time now{};
    window.path_takes(1ms);
    window.peer_waits(waits);
    std::uint64_t sent = 0;
    int without_room = 0;
    for (int i = 0; i < 300; ++i, now += 50ms) {
      without_room += window.room(now) < 3000;
      window.sent(3000, now);
      sent += 3000;
      if (i % 3 == 2) CHECK(window.acknowledged(sent, now + 50ms));
    }
    CHECK((without_room == 0) == (waits > 0ms));
  }
}

TEST_CASE("on a slow path little is under way") {
  // What goes out arrives in hardly more than the path's own time and the allowed delay, at any rate, and the path is
  // used.
  for (const double bytes_per_s : {20'000.0, 100'000.0, 1'000'000.0}) {
    CAPTURE(bytes_per_s);
    Path path{.delay = 20ms, .bytes_per_s = bytes_per_s};
    const auto longest = path.run(20s);
    CHECK(longest < 20ms + 2 * FlowLimits{}.delay + 100ms);
    CHECK(static_cast<double>(path.sent) > 0.8 * 20 * bytes_per_s);
  }
}

TEST_CASE("a path that becomes slow is not filled up") {
  // A lab says 4 kB/s, in small messages. Where 1 kB/s passes all of a sudden, no more goes out than arrives in two
  // seconds; a window that shrank only when the acknowledgement came let four go out.
  FlowWindow window{FlowLimits{}};
  FlowWindow::Time now{};
  window.path_takes(1ms);
  std::uint64_t sent = 0, arrived = 0;
  std::size_t most = 0;
  for (int ms = 0; ms < 20'000; ++ms, now += 1ms) {
    const bool slow = ms >= 5'000;
    arrived = std::min(sent, slow ? arrived + 1 : sent);
    if (ms % 20 == 0) CHECK(window.acknowledged(arrived, now));
    if (ms % 25 == 0 && window.room(now) >= 100) {
      window.sent(100, now);
      sent += 100;
    }
    most = std::max(most, window.under_way());
  }
  CHECK(most <= 2'000);
  CHECK(arrived > 30'000);
}

TEST_CASE("an acknowledgement of what was never sent is none") {
  // Neither more than was sent nor less than before; what waits is known with its time.
  FlowWindow window{FlowLimits{}};
  const FlowWindow::Time begin{};
  CHECK_FALSE(window.waits_since());
  window.sent(1000, begin + 1s);
  CHECK(window.waits_since() == begin + 1s);
  CHECK_FALSE(window.acknowledged(1001, begin + 2s));
  CHECK(window.acknowledged(500, begin + 3s));
  CHECK(window.waits_since() == begin + 3s);
  CHECK(window.acknowledged(500, begin + 4s));
  CHECK(window.waits_since() == begin + 3s);
  CHECK_FALSE(window.acknowledged(499, begin + 4s));
  CHECK(window.acknowledged(1000, begin + 4s));
  CHECK_FALSE(window.waits_since());
}

}  // namespace
}  // namespace arkmesh::gateway
