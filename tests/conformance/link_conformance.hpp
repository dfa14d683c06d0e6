// What gateway/link.hpp promises, as checks for any transport. Each takes a row of the table in link_test.cpp. A new
// link is done when its row passes.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gateway/link.hpp"

namespace arkmesh::tests {

using namespace gateway;

// Two labs, "left" and "right", that can be joined by a link with one end in each.
class LinkWorld {
 public:
  virtual ~LinkWorld() = default;
  // A new end of that lab, as after a start of its gateway. The lab's earlier end is gone.
  virtual std::unique_ptr<Link> end(const std::string& lab) = 0;
  // Cuts the line between them, or mends it.
  virtual void cut(bool is_cut) = 0;
  // Lets a little time pass.
  virtual void step() = 0;
};

struct LinkRow {
  std::string name;
  std::function<std::unique_ptr<LinkWorld>()> make;
};

// One end with everything that it told.
struct HeardEnd {
  std::unique_ptr<Link> link;
  std::vector<std::pair<std::string, std::string>> messages;  // channel, bytes
  std::vector<bool> changes;
  std::string why;
  int events = 0;
  std::function<void()> on_message = [] {};

  explicit HeardEnd(std::unique_ptr<Link> of) : link(std::move(of)) {}
  void start() {
    link->start({.arrived =
                     [this](std::string_view channel, std::span<const std::byte> bytes) {
                       ++events;
                       messages.emplace_back(channel,
                                             std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
                       on_message();
                     },
                 .changed =
                     [this](bool up, std::string_view reason) {
                       ++events;
                       if (changes.empty() || changes.back() != up) changes.push_back(up);
                       why = reason;
                     }});
  }
  void offer(Delivery delivery, const std::string& channel, std::string_view text) {
    link->offer({channel, delivery}, channel, std::as_bytes(std::span(text)));
  }
  std::vector<std::string> heard_on(const std::string& channel) const {
    std::vector<std::string> out;
    for (const auto& [name, text] : messages)
      if (name == channel) out.push_back(text);
    return out;
  }
};

struct LinkBench {
  std::unique_ptr<LinkWorld> world;
  HeardEnd left, right;

  explicit LinkBench(const LinkRow& row) : world(row.make()), left(world->end("left")), right(world->end("right")) {}
  template <class Condition>
  [[nodiscard]] bool until(Condition condition) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(300);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      world->step();
    }
    return true;
  }
  [[nodiscard]] bool both(bool up) {
    return until([&] { return left.link->stats().up == up && right.link->stats().up == up; });
  }
  void start() {
    left.start();
    right.start();
    REQUIRE(both(true));
  }
};

// Both ends are told when the link comes and goes, and why; stats say the same.
inline void check_up_and_down(const LinkRow& row) {
  LinkBench bench(row);
  CHECK_FALSE(bench.left.link->stats().up);
  CHECK(bench.left.link->stats().peer_boot_id == 0);
  CHECK(bench.left.link->peer() == "right");
  CHECK(bench.right.link->peer() == "left");
  bench.left.start();
  CHECK(bench.left.events == 0);  // not from within start()
  bench.right.start();
  REQUIRE(bench.both(true));
  for (int i = 0; i < 2; ++i) {
    bench.world->cut(true);
    REQUIRE(bench.both(false));
    CHECK_FALSE(bench.left.link->stats().why.empty());
    CHECK(bench.left.why == bench.left.link->stats().why);
    bench.world->cut(false);
    REQUIRE(bench.both(true));
  }
  for (HeardEnd* end : {&bench.left, &bench.right}) {
    // An end may have told that it is not up yet before it was.
    if (!end->changes.front()) end->changes.erase(end->changes.begin());
    CHECK(end->changes == std::vector<bool>{true, false, true, false, true});
    CHECK(end->link->stats().peer_boot_id != 0);
  }
}

// Messages of all sizes arrive unchanged and in order, both ways, on their channels; nothing is sent back.
inline void check_order(const LinkRow& row) {
  LinkBench bench(row);
  bench.start();
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < 200; ++i)
    texts.push_back(std::string((i * i * 37) % 5000, static_cast<char>('a' + i % 26)) + std::to_string(i));
  texts.emplace_back();  // an empty message is a message
  std::uint64_t bytes = 0;
  for (const std::string& text : texts) {
    bench.left.offer(Delivery::ordered, "events", text);
    bench.right.offer(Delivery::ordered, "world", text);
    bytes += text.size();
  }
  REQUIRE(bench.until(
      [&] { return bench.right.messages.size() == texts.size() && bench.left.messages.size() == texts.size(); }));
  CHECK(bench.right.heard_on("events") == texts);
  CHECK(bench.left.heard_on("world") == texts);
  REQUIRE(bench.until([&] { return bench.left.link->stats().sent_messages == texts.size(); }));
  CHECK(bench.left.link->stats().sent_bytes == bytes);
  CHECK(bench.left.link->stats().received_messages == texts.size());
  CHECK(bench.left.link->stats().received_bytes == bytes);
}

// A message of 1 MiB arrives, between small ones.
inline void check_large(const LinkRow& row) {
  LinkBench bench(row);
  bench.start();
  std::string large(1 << 20, '\0');
  for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>(i * 31 % 251);
  for (const std::string& text : {std::string("before"), large, std::string("after")})
    bench.left.offer(Delivery::ordered, "events", text);
  REQUIRE(bench.until([&] { return bench.right.messages.size() == 3; }));
  CHECK((bench.right.heard_on("events") == std::vector<std::string>{"before", large, "after"}));
}

// What is offered while the link is down: of `latest` the newest per channel arrives, of `ordered` everything.
inline void check_outage(const LinkRow& row) {
  LinkBench bench(row);
  bench.left.offer(Delivery::latest, "world", "before the start");
  bench.start();
  REQUIRE(bench.until([&] { return bench.right.messages.size() == 1; }));
  bench.world->cut(true);
  REQUIRE(bench.both(false));
  std::vector<std::string> all;
  for (int i = 0; i < 10; ++i) {
    all.push_back(std::to_string(i));
    bench.left.offer(Delivery::latest, "world", all.back());
    bench.left.offer(Delivery::latest, "status", all.back());
    bench.left.offer(Delivery::ordered, "events", all.back());
  }
  bench.world->cut(false);
  REQUIRE(bench.until([&] { return bench.right.messages.size() >= 13; }));
  CHECK((bench.right.heard_on("world") == std::vector<std::string>{"before the start", "9"}));
  CHECK(bench.right.heard_on("status") == std::vector<std::string>{"9"});
  CHECK(bench.right.heard_on("events") == all);
  CHECK(bench.left.link->stats().counters["outbox.replaced.world"] == 9);
  CHECK(bench.left.link->stats().counters["outbox.replaced.status"] == 9);
}

// A long outage costs the oldest `ordered` messages; every one of them is counted, and `latest` survives.
inline void check_overflow(const LinkRow& row) {
  LinkBench bench(row);
  bench.start();
  bench.world->cut(true);
  REQUIRE(bench.both(false));
  bench.left.offer(Delivery::latest, "world", "the newest");
  const std::string text(64 << 10, 'x');
  for (int i = 0; i < 100; ++i) bench.left.offer(Delivery::ordered, "events", std::to_string(i) + "," + text);
  const std::uint64_t dropped = bench.left.link->stats().counters["outbox.dropped.full.events"];
  CHECK(dropped > 30);
  CHECK(dropped < 50);
  bench.world->cut(false);
  REQUIRE(bench.until([&] { return bench.right.messages.size() == 101 - dropped; }));
  CHECK(bench.right.heard_on("world") == std::vector<std::string>{"the newest"});
  const auto events = bench.right.heard_on("events");
  for (std::size_t i = 0; i < events.size(); ++i) CHECK(events[i].starts_with(std::to_string(dropped + i) + ","));
}

// After stop() no event comes, though messages are under way and the peer goes on; the peer learns it.
inline void check_stop(const LinkRow& row) {
  LinkBench bench(row);
  bench.start();
  for (int i = 0; i < 50; ++i) bench.left.offer(Delivery::ordered, "events", std::string(1000, 'x'));
  bench.right.link->stop();
  const int events = bench.right.events;
  bench.right.offer(Delivery::latest, "world", "nobody hears this");
  REQUIRE(bench.until([&] { return !bench.left.link->stats().up; }));
  for (int i = 0; i < 20; ++i) bench.world->step();
  CHECK(bench.right.events == events);
  CHECK_FALSE(bench.right.link->stats().up);
  CHECK(bench.left.messages.empty());
}

// stop() from within an event is allowed.
inline void check_stop_inside(const LinkRow& row) {
  LinkBench bench(row);
  bench.right.on_message = [&] { bench.right.link->stop(); };
  bench.start();
  for (int i = 0; i < 10; ++i) bench.left.offer(Delivery::ordered, "events", "x");
  REQUIRE(bench.until([&] { return !bench.left.link->stats().up; }));
  for (int i = 0; i < 20; ++i) bench.world->step();
  CHECK(bench.right.messages.size() == 1);
}

// An end that is made anew is met again, with another boot id, and gets what comes from then on.
inline void check_restart(const LinkRow& row) {
  LinkBench bench(row);
  bench.start();
  const std::uint64_t first = bench.left.link->stats().peer_boot_id;
  bench.right.link.reset();
  bench.right.link = bench.world->end("right");
  bench.right.start();
  REQUIRE(bench.until([&] { return bench.left.link->stats().up && bench.left.link->stats().peer_boot_id != first; }));
  REQUIRE(bench.both(true));
  bench.left.offer(Delivery::latest, "world", "hello again");
  REQUIRE(bench.until([&] { return !bench.right.messages.empty(); }));
  CHECK(bench.right.messages.back().second == "hello again");
}

}  // namespace arkmesh::tests
