// Two relays joined by the worst of channels: both streams arrive whole, and nothing that a stranger repeats, invents
// or keeps for later becomes part of them.
#include "gateway/federation/relay.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "hal/random.hpp"

namespace arkmesh::gateway {
namespace {

using namespace std::chrono_literals;
using Time = Relay::Time;

std::string text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
ChunkPointer made_chunk(std::string_view said, bool is_message = true) {
  const auto bytes = std::as_bytes(std::span(said));
  return std::make_shared<const Chunk>(Chunk{{bytes.begin(), bytes.end()}, is_message});
}

// A packet on its way, with bytes of its own.
struct Letter {
  std::optional<Greeting> greeting;
  std::optional<Piece> piece;
  std::vector<ChunkPointer> chunks;
  PacketOrder at{};

  PacketBody body() const {
    PacketBody body;
    for (const ChunkPointer& each : chunks) body.chunks.emplace_back(each->bytes);
    return body;
  }
};

// One end, with what it has read so far.
struct RelayEnd {
  std::string name;
  Relay relay;
  std::string read;
  Time asked{};

  RelayEnd(std::string of, StreamId mine) : name(std::move(of)), relay(mine) {}
  void hear(const Letter& letter, Time now, std::vector<Letter>& answers) {
    if (letter.greeting && relay.hear(*letter.greeting, letter.at))
      answers.push_back({relay.greeting("", letter.greeting->mine), {}, {}});
    if (letter.piece && letter.piece->yours == relay.mine()) relay.take(*letter.piece, letter.body(), letter.at, now);
    read += text_of(relay.unread());
    relay.unread().clear();
  }
  // As a gateway does in each turn; a packet has so many chunks at most.
  void speak(Time now, std::size_t most, std::vector<Letter>& out) {
    relay.check(now);
    if (!relay.met()) {
      if (now - asked < 200ms) return;
      asked = now;
      return out.push_back({relay.greeting("", relay.yours()), {}, {}});
    }
    while (relay.next() || relay.owes_answer(now)) {
      Letter letter{{}, relay.piece(), {}};
      while (relay.next() && letter.chunks.size() < most) {
        letter.piece->chunks.push_back(static_cast<std::uint16_t>(letter.chunks.size()));
        letter.chunks.push_back(relay.share_next());
        letter.piece->is_urgent |= relay.sent(now);
      }
      out.push_back(std::move(letter));
    }
  }
};

// What happens to packets. Chances are of each of them.
struct Badness {
  double lost = 0, repeated = 0, old = 0;
  std::chrono::milliseconds delay{0}, jitter{0};  // jitter changes their order
};

class BadPath {
 public:
  BadPath(const Badness& badness, std::uint64_t seed) : badness_(badness), chance_(seed, "relay test") {}
  void put(std::vector<Letter> letters, Time now) {
    for (Letter& each : letters) {
      each.at = {1, ++numbers_};
      past_.push_back(each);
      for (bool again = true; again; again = chance_.uniform() < badness_.repeated)
        if (chance_.uniform() >= badness_.lost) enter(each, now);
      if (chance_.uniform() < badness_.old) enter(past_[chance_.below(past_.size())], now);
    }
  }
  std::vector<Letter> take(Time now) {
    std::vector<Letter> due;
    for (const auto& [at, letter] : on_its_way_)
      if (at <= now) due.push_back(letter);
    std::erase_if(on_its_way_, [&](const auto& each) { return each.first <= now; });
    return due;
  }
  std::size_t carried() const { return past_.size(); }

 private:
  void enter(const Letter& letter, Time now) {
    const auto late =
        badness_.delay + std::chrono::duration_cast<std::chrono::milliseconds>(badness_.jitter * chance_.uniform());
    on_its_way_.emplace_back(now + late, letter);
  }

  Badness badness_;
  hal::RandomStream chance_;
  std::vector<std::pair<Time, Letter>> on_its_way_;
  std::vector<Letter> past_;
  std::uint64_t numbers_ = 0;
};

struct RelayPair {
  RelayEnd left{"left", 11}, right{"right", 22};
  BadPath to_right, to_left;
  Time now{1000s};

  explicit RelayPair(const Badness& badness = {}, std::uint64_t seed = 1)
      : to_right(badness, seed), to_left(badness, ~seed) {}
  // 5 ms; what is said arrives in the next turn at the soonest.
  void turn(std::size_t most = 4) {
    now += 5ms;
    std::vector<Letter> of_left, of_right;
    for (const Letter& each : to_left.take(now)) left.hear(each, now, of_left);
    for (const Letter& each : to_right.take(now)) right.hear(each, now, of_right);
    left.speak(now, most, of_left);
    right.speak(now, most, of_right);
    to_right.put(std::move(of_left), now);
    to_left.put(std::move(of_right), now);
  }
  template <class Condition>
  bool until(Condition condition) {
    for (int i = 0; i < 100'000; ++i) {
      if (condition()) return true;
      turn();
    }
    return false;
  }
  void meet() {
    REQUIRE(until([&] { return left.relay.met() && right.relay.met(); }));
  }
};

TEST_CASE("a relay's streams arrive whole over any channel") {
  // Lost, repeated, late, out of order, and old ones once more: all bytes, once, in order, both ways, and then silence.
  const std::pair<const char*, Badness> table[] = {
      {"perfect", {}},
      {"late", {.delay = 40ms}},
      {"one in ten is lost", {.lost = 0.1, .delay = 5ms}},
      {"half are lost", {.lost = 0.5, .delay = 10ms}},
      {"repeated", {.repeated = 0.5, .delay = 5ms}},
      {"out of order", {.delay = 5ms, .jitter = 60ms}},
      {"old ones come again", {.old = 0.5, .delay = 5ms}},
      {"all of it", {.lost = 0.2, .repeated = 0.2, .old = 0.2, .delay = 5ms, .jitter = 100ms}},
      {"slower than it waits", {.lost = 0.1, .delay = 700ms, .jitter = 700ms}},
  };
  for (const auto& row : table)
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      CAPTURE(row.first);
      CAPTURE(seed);
      RelayPair pair(row.second, seed);
      hal::RandomStream chance(seed, "relay test/what is said");
      std::string by_left, by_right;
      for (int i = 0; i < 400; ++i) {
        for (const auto& [end, said] : {std::pair(&pair.left, &by_left), std::pair(&pair.right, &by_right)})
          if (chance.uniform() < 0.3) {
            const std::string each = std::to_string(i) + std::string(chance.below(300), 'x');
            end->relay.put(made_chunk(each));
            *said += each;
          }
        pair.turn(1 + chance.below(8));
      }
      const auto is_over = [&] {
        REQUIRE(by_right.starts_with(pair.left.read));
        REQUIRE(by_left.starts_with(pair.right.read));
        return pair.left.read == by_right && pair.right.read == by_left;
      };
      REQUIRE(pair.until(is_over));
      CHECK_FALSE(pair.left.relay.ended());
      CHECK_FALSE(pair.right.relay.ended());
      // What has arrived is acknowledged in the end, and nothing more is said.
      for (int i = 0; i < 4000; ++i) pair.turn();
      const std::size_t carried = pair.to_left.carried() + pair.to_right.carried();
      for (int i = 0; i < 400; ++i) pair.turn();
      if (row.second.old == 0) CHECK(pair.to_left.carried() + pair.to_right.carried() == carried);
      CHECK(is_over());
    }
}

TEST_CASE("on a perfect path nothing is sent twice") {
  // Acknowledgements come in time, so that no piece is repeated or missing.
  RelayPair pair({.delay = 30ms});
  pair.meet();
  for (int i = 0; i < 1000; ++i) {
    pair.left.relay.put(made_chunk("some of it "));
    pair.turn();
  }
  REQUIRE(pair.until([&] { return pair.right.read.size() == 11 * 1000; }));
  for (int i = 0; i < 400; ++i) pair.turn();
  for (const RelayEnd* end : {&pair.left, &pair.right})
    for (const char* counter : {"pieces.sent_again", "pieces.repeated", "pieces.missing", "pieces.full"})
      CHECK(end->relay.counters()[counter] == 0);
}

TEST_CASE("acknowledgements that may wait are few") {
  // One for what came in 200 ms, and nobody says anything again for want of them; but what is lost is said again.
  for (const double lost : {0.0, 0.1}) {
    CAPTURE(lost);
    RelayPair pair({.lost = lost, .delay = 5ms});
    pair.meet();
    for (RelayEnd* end : {&pair.left, &pair.right}) end->relay.acknowledge_within(200ms);
    std::string said;
    const std::size_t before = pair.to_left.carried();
    for (int i = 0; i < 200; ++i) {
      said += std::to_string(i);
      pair.left.relay.put(made_chunk(std::to_string(i)));
      for (int turns = 0; turns < 10; ++turns) pair.turn();
    }
    REQUIRE(pair.until([&] { return pair.right.read == said; }));
    if (lost > 0) continue;
    CHECK(pair.to_left.carried() - before <= 1 + 10'000 / 200);
    CHECK(pair.left.relay.counters()["pieces.sent_again"] == 0);
  }
}

TEST_CASE("a relay learns that the other end was started again") {
  // It ends; a new one of either side meets the new one, and gets its stream from the beginning.
  RelayPair pair({.lost = 0.2, .delay = 5ms});
  pair.meet();
  pair.left.relay.put(made_chunk("to the first"));
  REQUIRE(pair.until([&] { return pair.right.read == "to the first"; }));
  for (int i = 0; i < 100; ++i) pair.turn();  // until left knows that it has
  pair.right = RelayEnd("right", 33);
  pair.right.relay.put(made_chunk("hello"));  // as a session does
  pair.left.relay.put(made_chunk(", to nobody"));
  REQUIRE(pair.until([&] { return pair.left.relay.ended(); }));
  CHECK(pair.right.read.empty());
  pair.left = RelayEnd("left", 44);
  pair.left.relay.put(made_chunk("to the second"));
  // The second has not heard anything of the first end of left, so it stays.
  REQUIRE(pair.until([&] { return pair.right.read == "to the second" && pair.left.read == "hello"; }));
  CHECK_FALSE(pair.left.relay.ended());
}

TEST_CASE("what was said to an earlier end is not heard") {
  // All packets of an earlier conversation of the same two labs, once more and in order: nothing of them is read, and
  // the present conversation goes on.
  std::vector<Letter> past;
  RelayPair pair;
  for (int i = 0; i < 200; ++i) {
    std::vector<Letter> of_left, of_right;
    pair.now += 5ms;
    for (const Letter& each : pair.to_right.take(pair.now)) pair.right.hear(each, pair.now, of_right);
    for (const Letter& each : pair.to_left.take(pair.now)) pair.left.hear(each, pair.now, of_left);
    if (i % 10 == 0) pair.left.relay.put(made_chunk("then "));
    pair.left.speak(pair.now, 4, of_left);
    pair.right.speak(pair.now, 4, of_right);
    past.insert(past.end(), of_left.begin(), of_left.end());
    pair.to_right.put(std::move(of_left), pair.now);
    pair.to_left.put(std::move(of_right), pair.now);
  }
  REQUIRE(pair.right.read.size() == 100);
  pair.left = RelayEnd("left", 55);
  pair.right = RelayEnd("right", 66);
  for (const Letter& each : past) {
    std::vector<Letter> answers;
    pair.right.hear(each, pair.now, answers);
    CHECK(answers.size() <= 1);
  }
  CHECK(pair.right.read.empty());
  CHECK_FALSE(pair.right.relay.met());
  pair.left.relay.put(made_chunk("now"));
  REQUIRE(pair.until([&] { return pair.right.read == "now"; }));
  for (const Letter& each : past) {
    std::vector<Letter> answers;
    pair.right.hear(each, pair.now, answers);
  }
  CHECK(pair.right.read == "now");
  pair.left.relay.put(made_chunk(" and then"));
  REQUIRE(pair.until([&] { return pair.right.read == "now and then"; }));
  CHECK_FALSE(pair.left.relay.ended());
}

TEST_CASE("an acknowledgement of what was never sent ends the stream") {
  // Also of what waits to be sent; and one that is older than the last changes nothing.
  for (const bool waits : {false, true}) {
    RelayPair pair;
    pair.meet();
    pair.left.relay.put(made_chunk("0123456789"));
    REQUIRE(pair.until([&] { return pair.right.read.size() == 10; }));
    for (int i = 0; i < 20; ++i) pair.turn();
    if (waits) pair.left.relay.put(made_chunk("9876543210"));
    CHECK(pair.left.relay.take({.yours = 11, .mine = 22, .acknowledged = 3}, {}, {1, 1}, pair.now));
    CHECK_FALSE(pair.left.relay.ended());
    CHECK_FALSE(pair.left.relay.take({.yours = 11, .mine = 22, .acknowledged = 11}, {}, {1, 1}, pair.now));
    CHECK(pair.left.relay.ended());
  }
}

TEST_CASE("what nobody reads is not taken") {
  // No more is held than the limit; the rest comes once there is room, unchanged.
  RelayPair pair;
  pair.meet();
  std::string said;
  for (int i = 0; i < 150; ++i) {
    const std::string each(16'000, static_cast<char>('a' + i % 26));
    pair.left.relay.put(made_chunk(each));
    said += each;
  }
  std::vector<Letter> letters, answers;
  std::vector<std::byte> held;
  for (int turn = 0; turn < 200; ++turn) {
    pair.now += 5ms;
    pair.left.speak(pair.now, 10, letters);
    for (const Letter& each : std::exchange(letters, {}))
      if (each.piece) pair.right.relay.take(*each.piece, each.body(), each.at, pair.now);
    pair.right.speak(pair.now, 10, letters);
    for (const Letter& each : std::exchange(letters, {})) pair.left.hear(each, pair.now, answers);
    CHECK(pair.right.relay.unread().size() <= Relay::max_unread_bytes);
  }
  CHECK(pair.right.relay.unread().size() > Relay::max_unread_bytes - 16'000);
  CHECK(pair.right.relay.counters()["pieces.full"] > 0);
  REQUIRE(pair.until([&] { return pair.right.read.size() == said.size(); }));
  CHECK(pair.right.read == said);
}

TEST_CASE("what an earlier end of the peer said ends nothing") {
  // Its greetings and pieces were for this end of ours, and come once more when the peer has another end: by the order
  // of the packets they are of the past. A later one of yet another end does end the stream.
  Relay relay(11);
  const Greeting first{"left", 22, 11, true}, second{"left", 33, 11, true};
  CHECK(relay.hear(first, {1, 5}));
  CHECK(relay.hear(second, {1, 8}));
  CHECK(relay.yours() == 33);
  const std::vector<std::byte> bytes(4, std::byte{'x'});
  const PacketBody body{.chunks = {bytes}};
  CHECK(relay.take({.yours = 11, .mine = 33, .chunks = {0}}, body, {1, 9}, {}));
  CHECK_FALSE(relay.hear(first, {1, 5}));
  CHECK(relay.take({.yours = 11, .mine = 22, .chunks = {0, 0}}, body, {1, 6}, {}));
  CHECK(relay.take({.yours = 11, .mine = 22, .chunks = {0, 0}}, body, {0, 100}, {}));
  CHECK(relay.yours() == 33);
  CHECK(relay.unread().size() == 4);
  CHECK_FALSE(relay.ended());
  CHECK_FALSE(relay.hear({"left", 44, 11, true}, {1, 10}));
  CHECK(relay.ended());
}

TEST_CASE("an ending counts for its own stream only") {
  // Another number of either end is of a stream that is no more.
  RelayPair pair;
  pair.meet();
  pair.left.relay.hear(Ending{.yours = 11, .mine = 23});
  CHECK_FALSE(pair.left.relay.ended());
  pair.left.relay.hear(Ending{.yours = 11, .mine = 22});
  CHECK(pair.left.relay.ended());
}

}  // namespace

TEST_CASE("what is about the session asks for no acknowledgement of its own") {
  // A message is acknowledged within 20 ms; what answers it, a session's own acknowledgement, is not, or the two ends
  // would answer each other without end. It is acknowledged with whatever goes next.
  RelayEnd left("left", 1), right("right", 2);
  Time now{1s};
  const auto pass = [&now](RelayEnd& from, RelayEnd& to, std::uint64_t number) {
    std::vector<Letter> letters, answers;
    from.speak(now, 10, letters);
    for (Letter& each : letters) {
      each.at = {1, number};
      to.hear(each, now, answers);
    }
    for (Letter& each : answers) {
      each.at = {1, number};
      from.hear(each, now, letters);
    }
    return letters.size();
  };
  std::uint64_t number = 0;
  while (!left.relay.met() || !right.relay.met()) {
    pass(left, right, ++number);
    pass(right, left, ++number);
    now += 200ms;
  }
  const auto put = [](RelayEnd& end, bool is_message) {
    end.relay.put(std::make_shared<const Chunk>(Chunk{std::vector<std::byte>(10), is_message}));
  };
  // The beginnings of both streams are acknowledged soon.
  put(left, false);
  put(right, false);
  for (int i = 0; i < 4; ++i, now += 20ms) pass(left, right, ++number), pass(right, left, ++number);
  REQUIRE_FALSE(left.relay.owes_answer(now));
  REQUIRE_FALSE(right.relay.owes_answer(now));
  put(left, true);
  CHECK(pass(left, right, ++number) == 1);
  now += 20ms;
  CHECK(right.relay.owes_answer(now));
  put(right, false);
  CHECK(pass(right, left, ++number) == 1);
  now += 60ms;
  CHECK_FALSE(left.relay.owes_answer(now));
  // Nothing is said again before the longest patience.
  now += 500ms;
  CHECK(pass(right, left, ++number) == 0);
  put(left, true);
  CHECK(pass(left, right, ++number) == 1);  // carries the acknowledgement
  now += 2s;
  CHECK(pass(right, left, ++number) == 1);  // its own, and nothing again
  CHECK(right.relay.counters()["pieces.sent_again"] == 0);
}

}  // namespace arkmesh::gateway
