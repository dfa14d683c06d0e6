// The outbox: what goes next, what waits, is replaced, dropped or sent again, and that it never holds more than it may.
#include "gateway/outbox/outbox.hpp"

#include <doctest/doctest.h>

#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "gateway/frame/frame.hpp"
#include "hal/random.hpp"
#include "tests/support/network/accounts.hpp"

namespace arkmesh::gateway {
namespace {

constexpr std::size_t all_frames = 1'000'000, all_bytes = 1 << 30;
constexpr Delivery latest = Delivery::latest, ordered = Delivery::ordered;
using namespace std::chrono_literals;
using Texts = std::vector<std::string>;

struct TestedOutbox : Outbox {
  using Outbox::Outbox;
  bool say(Delivery delivery, std::string_view channel, std::string_view text) {
    return say(Rule{std::string(channel), delivery}, text);
  }
  bool say(const Rule& rule, std::string_view text) { return put(rule, std::as_bytes(std::span(text)), now); }
  // What a batch writes: texts of messages; "..." for a part of one.
  Texts take(std::size_t frames = all_frames, std::size_t bytes = all_bytes) {
    Texts out;
    for (const auto part : batch(frames, bytes, now)) {
      taken += part.size();
      FrameDecoder decoder(max_frame_payload_bytes);
      std::span<const std::byte> rest = part;
      const auto frame = decoder.next(rest);
      REQUIRE(frame);
      REQUIRE(rest.empty());
      const auto payload = assembler.take(*frame, all_bytes);
      out.push_back(payload ? text_of(*payload) : "...");
    }
    return out;
  }
  std::string text_of(std::span<const std::byte> payload) {
    const auto message = read_message(payload);
    REQUIRE(message);
    numbers.push_back(message->sequence);
    return {reinterpret_cast<const char*>(message->bytes.data()), message->bytes.size()};
  }
  Sent write() { return written(std::exchange(taken, 0)); }
  void lose_session() {
    taken = 0;
    session_lost();
  }
  // The peer has all that was taken.
  void deliver(std::size_t messages) {
    write();
    CHECK(acknowledged(messages));
  }
  std::uint64_t count(const std::string& name) const { return counters()["outbox." + name]; }
  void check() const {
    LinkStats stats;
    stats.counters = counters();
    tests::check_accounts(stats);
  }

  Time now{1h};
  std::size_t taken = 0;
  MessageAssembler assembler;
  std::vector<std::uint64_t> numbers;  // of what was taken
};

TEST_CASE("latest replaces, ordered queues") {
  // A newer `latest` message takes the place of a waiting one of its channel; `ordered` messages all stay, numbered.
  TestedOutbox outbox(10'000);
  outbox.say(latest, "world", "w1");
  outbox.say(ordered, "events", "e1");
  outbox.say(latest, "status", "s1");
  outbox.say(latest, "world", "w2");
  outbox.say(ordered, "events", "e2");
  CHECK(outbox.take() == Texts{"w2", "e1", "s1", "e2"});
  CHECK(outbox.numbers == std::vector<std::uint64_t>{0, 1, 0, 2});
  CHECK(outbox.count("replaced.world") == 1);
  CHECK(outbox.count("replaced.events") == 0);
  outbox.check();
}

TEST_CASE("what is under way is not touched, and counts until it is acknowledged") {
  // A newer message waits behind it; what the peer has frees its place.
  TestedOutbox outbox(10'000);
  outbox.say(latest, "world", "old");
  CHECK(outbox.take() == Texts{"old"});
  outbox.say(latest, "world", "new");
  outbox.say(latest, "world", "newer");
  CHECK(outbox.waiting_messages() == 1);
  CHECK(outbox.count("in_flight.world") == 1);
  CHECK(outbox.written(outbox.taken - 1).messages == 0);
  CHECK(outbox.written(1).bytes == 3);
  outbox.taken = 0;
  CHECK(outbox.take() == Texts{"newer"});
  outbox.deliver(2);
  CHECK(outbox.empty());
  CHECK(outbox.count("replaced.world") == 1);
  CHECK(outbox.count("acknowledged.world") == 2);
  outbox.check();
}

TEST_CASE("nothing is acknowledged that was not written") {
  // A peer cannot free what is being written, nor what it was never sent.
  TestedOutbox outbox(10'000);
  outbox.say(ordered, "events", "a");
  CHECK_FALSE(outbox.acknowledged(1));
  outbox.say(ordered, "events", "b");
  outbox.take();
  CHECK_FALSE(outbox.acknowledged(1));
  CHECK(outbox.written(outbox.taken - 1).messages == 1);
  CHECK_FALSE(outbox.acknowledged(2));
  CHECK(outbox.acknowledged(1));
  CHECK_FALSE(outbox.acknowledged(1));
}

TEST_CASE("a session that is lost loses no ordered message") {
  // They go again, with their numbers, before what waits. Of `latest` the newest goes again unless a newer one waits.
  TestedOutbox outbox(100'000);
  for (const char* event : {"e1", "e2"}) outbox.say(ordered, "events", event);
  outbox.say(latest, "world", "w1");
  outbox.say(latest, "status", "s1");
  outbox.take();
  outbox.say(latest, "status", "s2");
  outbox.take();
  outbox.deliver(1);
  outbox.say(ordered, "events", "e3");
  outbox.say(latest, "world", "w2");
  outbox.lose_session();
  CHECK(outbox.count("dropped.session_lost.world") == 1);
  CHECK(outbox.count("dropped.session_lost.status") == 2);
  outbox.check();
  outbox.send_again(false);
  outbox.numbers.clear();
  CHECK(outbox.take() == Texts{"e2", "e3", "w2", "s2"});
  CHECK(outbox.numbers == std::vector<std::uint64_t>{2, 3, 0, 0});
  outbox.check();
  outbox.deliver(4);
  CHECK(outbox.ordered_accepted() == 3);
  CHECK(outbox.ordered_pending() == 0);
}

TEST_CASE("a peer that was started again gets what it had") {
  // The newest of each `latest` channel goes again to a peer that has nothing, and only to that one.
  TestedOutbox outbox(100'000);
  outbox.say(latest, "world", "w1");
  outbox.say(ordered, "events", "e1");
  outbox.take();
  outbox.deliver(2);
  outbox.lose_session();
  outbox.send_again(false);
  CHECK(outbox.empty());
  outbox.lose_session();
  outbox.send_again(true);
  CHECK(outbox.take() == Texts{"w1"});
  outbox.check();
  // It takes no room from what waits.
  outbox.deliver(1);
  CHECK(outbox.say(ordered, "events", std::string(100'000 - Outbox::overhead_bytes - 200, 'x')));
  outbox.send_again(true);
  CHECK(outbox.waiting_messages() == 1);
}

TEST_CASE("small messages do not wait for large ones") {
  // A message of many frames is handed out frame by frame; what is small goes between, and neither starves the other.
  TestedOutbox outbox(10'000'000);
  const std::string large(3 * max_frame_payload_bytes - 100, 'x');
  outbox.say(latest, "world", large);
  CHECK(outbox.take(1) == Texts{"..."});
  outbox.say(latest, "status", "urgent");
  CHECK(outbox.take(1) == Texts{"urgent"});
  CHECK(outbox.take(1) == Texts{"..."});
  // A flood of small ones leaves it every second frame's worth of bytes.
  const std::string half(max_frame_payload_bytes / 2, 'y');
  for (int i = 0; i < 10; ++i) outbox.say(ordered, "events", half);
  CHECK(outbox.take(4) == Texts{half, half, large, half});
  // What follows a large one of its channel does not overtake it.
  outbox.take();
  outbox.say(ordered, "log", large);
  outbox.say(ordered, "log", "after");
  outbox.say(ordered, "events", "before");
  CHECK(outbox.take() == Texts{"before", "...", "...", large, "after"});
  outbox.check();
  // Nor after both came back.
  outbox.lose_session();
  outbox.say(ordered, "log", "last");
  Texts again = outbox.take();
  std::erase_if(again, [&](const std::string& text) { return text == half || text == "..." || text == "before"; });
  CHECK(again == Texts{large, "after", "last"});
}

TEST_CASE("a large message that was cut off begins anew") {
  // The parts that went out with the lost session are of no use.
  TestedOutbox outbox(10'000'000);
  const std::string large(2 * max_frame_payload_bytes, 'x');
  for (const Delivery delivery : {ordered, latest}) {
    outbox.say(delivery, delivery == ordered ? "log" : "world", large);
    CHECK(outbox.take(1) == Texts{"..."});
    outbox.lose_session();
    outbox.assembler = {};
    outbox.send_again(false);
    CHECK(outbox.take() == Texts{"...", "...", large});
    outbox.deliver(1);
    outbox.check();
  }
}

TEST_CASE("a full outbox drops the oldest ordered first") {
  // Room is made at the cost of old `ordered` messages, then of old `latest` ones, never of what is under way.
  const std::string text(100, 'x');
  Outbox one(10'000);
  one.put({"events", ordered}, std::as_bytes(std::span(text)), {});
  const std::size_t each = one.bytes();
  TestedOutbox outbox(3 * each);
  outbox.say(latest, "worlds", text);
  outbox.say(ordered, "events", text);
  outbox.say(ordered, "events", text);
  CHECK(outbox.say(ordered, "events", text));
  CHECK(outbox.take(2).size() == 2);
  CHECK(outbox.numbers.back() == 2);
  CHECK(outbox.count("dropped.full.events") == 1);
  // The first two are under way: only the third can go.
  CHECK(outbox.say(ordered, "events", text));
  CHECK(outbox.say(latest, "states", text));
  CHECK(outbox.count("dropped.full.events") == 3);
  CHECK(outbox.say(latest, "others", text));
  CHECK(outbox.count("dropped.full.states") == 1);
  outbox.take();
  CHECK_FALSE(outbox.say(ordered, "events", text));
  CHECK(outbox.count("dropped.full.events") == 4);
  CHECK(outbox.bytes() == 3 * each);
  outbox.check();
}

TEST_CASE("messages that are too long are refused") {
  // Nothing longer than the whole outbox, or than the peer takes, is kept, also when that is learnt later.
  TestedOutbox outbox(1000);
  CHECK_FALSE(outbox.say(latest, "world", std::string(1001 - Outbox::overhead_bytes, 'x')));
  CHECK(outbox.say(latest, "world", std::string(900 - Outbox::overhead_bytes, 'x')));
  CHECK(outbox.say(latest, "world", "short"));
  outbox.set_longest(4);
  CHECK(outbox.empty());
  CHECK(outbox.bytes() == 0);
  CHECK_FALSE(outbox.say(latest, "world", "12345"));
  CHECK(outbox.say(latest, "world", "1234"));
  CHECK(outbox.count("refused.too_big.world") == 3);
  outbox.check();
}

TEST_CASE("batches keep their limits") {
  // A batch has at most so many frames and bytes, but a frame that is larger goes alone; with no room nothing goes.
  TestedOutbox outbox(100'000);
  for (int i = 0; i < 10; ++i) outbox.say(ordered, "events", std::string(100, 'x'));
  CHECK(outbox.take(3, 10'000).size() == 3);
  CHECK(outbox.take(100, 350).size() == 2);
  CHECK(outbox.take(100, 50).size() == 1);
  CHECK(outbox.take(100, 0).empty());
}

TEST_CASE("a rate sends the newest, and no more often") {
  // Three seconds of 10 Hz at 2 Hz: what goes is the newest of its time, at once after a pause; the rest is counted.
  TestedOutbox outbox(100'000);
  const Rule rule{.channel = "poses", .rate_hz = 2};
  std::vector<std::string> sent;
  const auto begun = outbox.now;
  for (int i = 0; i < 30; ++i, outbox.now = begun + i * 100ms) {
    outbox.say(rule, std::to_string(i));
    for (const std::string& text : outbox.take()) sent.push_back(text);
    outbox.deliver(outbox.count("in_flight.poses"));
    outbox.check();
  }
  CHECK(sent == Texts{"0", "5", "10", "15", "20", "25"});
  CHECK(outbox.count("dropped.rate_limited.poses") == 23);
  CHECK(outbox.waiting_messages() == 1);
  CHECK(outbox.next_release() == begun + 2990ms);  // 10 ms early: what goes late is made up for
  // The last one goes although nothing comes after it.
  outbox.now = begun + 3s;
  CHECK(outbox.take() == Texts{"29"});
  CHECK_FALSE(outbox.next_release());
}

TEST_CASE("a rate keeps ordered messages waiting, all and in order") {
  TestedOutbox outbox(100'000);
  const Rule rule{.channel = "events", .delivery = ordered, .rate_hz = 10};
  for (int i = 0; i < 5; ++i) outbox.say(rule, std::to_string(i));
  CHECK(outbox.waiting_messages() == 5);
  Texts sent;
  for (int i = 0; i < 5; ++i, outbox.now += 100ms) {
    const Texts now_sent = outbox.take();
    CHECK(now_sent.size() == 1);
    sent.insert(sent.end(), now_sent.begin(), now_sent.end());
    outbox.deliver(1);
  }
  CHECK(sent == Texts{"0", "1", "2", "3", "4"});
  CHECK(outbox.empty());
  // Those of a lost session go again at once, before what is held back.
  for (int i = 5; i < 7; ++i) outbox.say(rule, std::to_string(i));
  CHECK(outbox.take() == Texts{"5"});
  outbox.lose_session();
  outbox.now += 10s;
  CHECK(outbox.take() == Texts{"5"});
  outbox.now += 10s;
  CHECK(outbox.take() == Texts{"6"});
  outbox.check();
}

TEST_CASE("a byte budget waits as long as its messages are large") {
  // 1000 bytes a second: after 500 bytes half a second, after 100 a tenth; a message for which another channel has no
  // limit does not wait.
  TestedOutbox outbox(100'000);
  const Rule rule{.channel = "map", .bytes_per_s = 1000};
  outbox.say(rule, std::string(500, 'a'));
  CHECK(outbox.take().size() == 1);
  outbox.say(rule, std::string(100, 'b'));
  outbox.say(rule, std::string(100, 'c'));
  outbox.say(latest, "world", "w");
  outbox.now += 450ms;
  CHECK(outbox.take() == Texts{"w"});
  CHECK(outbox.count("dropped.over_budget.map") == 1);
  outbox.now += 50ms;
  CHECK(outbox.take() == Texts{std::string(100, 'c')});
  outbox.say(rule, "d");
  outbox.now += 100ms;
  CHECK(outbox.take() == Texts{"d"});
  outbox.check();
}

TEST_CASE("what is denied later does not go, nor come back") {
  // Neither what waits or is held back, nor what was under way when the session ended; until it is allowed again.
  TestedOutbox outbox(100'000);
  const Rule slow{.channel = "slow", .delivery = ordered, .rate_hz = 1};
  for (const char* text : {"1", "2"}) {
    outbox.say(ordered, "events", text);
    outbox.say(latest, "world", text);
    outbox.say(slow, text);
    if (*text == '1') CHECK(outbox.take().size() == 3);
  }
  outbox.keep_only([](std::string_view channel) { return channel == "world"; });
  CHECK(outbox.count("dropped.denied.events") == 1);
  CHECK(outbox.count("dropped.denied.slow") == 1);
  outbox.check();
  outbox.lose_session();
  outbox.send_again(true);
  outbox.now += 10s;
  CHECK(outbox.take() == Texts{"2"});
  CHECK(outbox.count("dropped.denied.events") == 2);
  CHECK(outbox.count("dropped.denied.slow") == 2);
  outbox.deliver(1);
  outbox.keep_only([](std::string_view) { return false; });
  outbox.lose_session();
  outbox.send_again(true);
  CHECK(outbox.empty());
  outbox.say(ordered, "events", "3");
  CHECK(outbox.take() == Texts{"3"});
  outbox.check();
}

TEST_CASE("random use keeps the books") {
  // Over 100,000 random steps with lost sessions: the limit holds, the accounts balance, a peer that drops repeats gets
  // every `ordered` message that was not dropped, once and in order, and `latest` ones in order.
  hal::RandomStream random(7, "outbox_test");
  const std::size_t limit = 100'000;
  TestedOutbox outbox(limit);
  // The last of them with rules that change now and then, as a reload does.
  std::vector<Rule> rules{{"world", latest}, {"status", latest}, {"events", ordered}, {"log", ordered},
                          {"poses", latest}, {"alarm", ordered}, {"map", latest}};
  const auto change = [&](Rule& rule) {
    rule.rate_hz = random.below(2) == 0 ? Rule::unlimited : random.uniform(1, 2000);
    rule.bytes_per_s = random.below(2) == 0 ? Rule::unlimited : random.uniform(1000, 1'000'000);
  };
  std::uint64_t number = 0;
  std::map<std::string, std::uint64_t> newest, newest_sequence, arrived;
  std::size_t unacknowledged = 0;
  for (int step = 0; step < 100'000; ++step) {
    const auto chance = random.below(100);
    if (chance < 50) {
      const std::size_t which = random.below(rules.size());
      if (which >= 4 && random.below(50) == 0) change(rules[which]);
      const Rule& rule = rules[which];
      const std::string& channel = rule.channel;
      outbox.now += std::chrono::microseconds(random.below(300));
      std::string message = channel + " " + std::to_string(++number) + " ";
      message.resize(message.size() + random.below(random.below(20) == 0 ? 60'000 : 300), 'x');
      outbox.say(rule, message);
    } else if (chance < 80) {
      outbox.numbers.clear();
      std::size_t complete = 0;
      for (const std::string& text : outbox.take(1 + random.below(20), random.below(40'000))) {
        if (text == "...") continue;
        const std::string channel = text.substr(0, text.find(' '));
        const std::uint64_t n = std::stoull(text.substr(text.find(' ') + 1)), sequence = outbox.numbers[complete++];
        if (sequence > 0 && sequence <= newest_sequence[channel]) continue;  // a repeat
        newest_sequence[channel] = sequence;
        REQUIRE(n >= newest[channel]);  // what was lost with a session may come again
        REQUIRE((sequence == 0 || n > newest[channel]));
        newest[channel] = n;
        ++arrived[channel];
      }
      CHECK(outbox.write().messages == complete);
      unacknowledged += complete;
    } else if (chance < 98) {
      const std::size_t some = random.below(unacknowledged + 1);
      REQUIRE(outbox.acknowledged(some));
      unacknowledged -= some;
    } else if (random.below(10) == 0) {
      const std::size_t some = random.below(rules.size());
      outbox.keep_only([&](std::string_view channel) { return some < 4 || channel != rules[some].channel; });
    } else {
      outbox.lose_session();
      outbox.assembler = {};
      outbox.send_again(random.below(2) == 0);
      unacknowledged = 0;
    }
    REQUIRE(outbox.bytes() <= limit);
    if (step % 100 == 0) outbox.check();
  }
  outbox.check();
  while (!outbox.take().empty()) outbox.write();
  CHECK(arrived["events"] > 1000);
  for (const std::string channel : {"events", "log"}) {
    CAPTURE(channel);
    CHECK(outbox.count("dropped.full." + channel) > 30);
    CHECK(outbox.count("acknowledged." + channel) > 1000);
    CHECK(outbox.count("refused.too_big." + channel) == 0);
  }
  CHECK(outbox.count("dropped.session_lost.world") > 100);
  outbox.check();
  for (const char* reason : {"rate_limited", "over_budget"})
    CHECK(outbox.count(std::string("dropped.") + reason + ".poses") > 100);
  // In the end all goes.
  for (; outbox.next_release(); outbox.now = *outbox.next_release()) {
    while (!outbox.take().empty()) outbox.write();
    if (!outbox.next_release()) break;
  }
  CHECK(outbox.waiting_messages() == 0);
}

}  // namespace
}  // namespace arkmesh::gateway
