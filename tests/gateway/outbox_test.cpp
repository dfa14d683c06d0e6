// The outbox: what waits, what is replaced, what is dropped, and that it never holds more than it may.
#include "gateway/outbox.hpp"

#include <doctest/doctest.h>

#include <map>
#include <string>
#include <vector>

#include "hal/random.hpp"

namespace arkmesh::gateway {
namespace {

std::vector<std::byte> bytes(std::string_view text) {
  const auto span = std::as_bytes(std::span(text));
  return {span.begin(), span.end()};
}

std::string text(std::span<const std::byte> part) {
  return {reinterpret_cast<const char*>(part.data()), part.size()};
}

// All that a batch would write.
std::vector<std::string> batch(Outbox& outbox, std::size_t messages = 100, std::size_t max_bytes = 1 << 20) {
  std::vector<std::string> out;
  for (const auto part : outbox.batch(messages, max_bytes)) out.push_back(text(part));
  return out;
}

using Texts = std::vector<std::string>;

TEST_CASE("latest replaces, ordered queues") {
  // A newer `latest` message takes the place of a waiting one of its channel; `ordered` messages all stay.
  Outbox outbox(10'000);
  outbox.put(Delivery::latest, "world", bytes("w1"));
  outbox.put(Delivery::ordered, "events", bytes("e1"));
  outbox.put(Delivery::latest, "status", bytes("s1"));
  outbox.put(Delivery::latest, "world", bytes("w2"));
  outbox.put(Delivery::ordered, "events", bytes("e2"));
  CHECK(batch(outbox) == Texts{"w2", "e1", "s1", "e2"});
  CHECK(outbox.counters()["outbox.replaced.world"] == 1);
  CHECK(outbox.counters()["outbox.replaced.events"] == 0);
}

TEST_CASE("what is being written is not touched") {
  // A message that was handed out stays as it is until it is written; a newer one waits behind it.
  Outbox outbox(10'000);
  outbox.put(Delivery::latest, "world", bytes("old"));
  const auto parts = outbox.batch(10, 1000);
  outbox.put(Delivery::latest, "world", bytes("new"));
  outbox.put(Delivery::latest, "world", bytes("newer"));
  CHECK(text(parts[0]) == "old");
  CHECK(outbox.messages() == 2);
  CHECK_FALSE(outbox.in_message());
  CHECK(outbox.written(1).messages == 0);
  CHECK(outbox.in_message());
  CHECK(batch(outbox) == Texts{"ld", "newer"});
  CHECK(outbox.written(2 + 5).messages == 2);
  CHECK(outbox.empty());
  CHECK(outbox.bytes() == 0);
  CHECK(outbox.counters()["outbox.replaced.world"] == 1);
}

TEST_CASE("handed out but not written can be replaced again") {
  // When only part of a batch was taken, the rest waits as before.
  Outbox outbox(10'000);
  outbox.put(Delivery::ordered, "events", bytes("abc"));
  outbox.put(Delivery::latest, "world", bytes("old"));
  batch(outbox);
  CHECK(outbox.written(3).messages == 1);
  outbox.put(Delivery::latest, "world", bytes("new"));
  CHECK(batch(outbox) == Texts{"new"});
}

TEST_CASE("a session that ends in the middle loses nothing") {
  // After rewind() the cut message begins anew, and of one channel only the newest is kept.
  Outbox outbox(10'000);
  for (const char* event : {"e1", "e2"}) outbox.put(Delivery::ordered, "events", bytes(event));
  outbox.put(Delivery::latest, "world", bytes("w1"));
  batch(outbox);
  outbox.put(Delivery::latest, "world", bytes("w2"));
  outbox.written(1);
  outbox.rewind();
  CHECK_FALSE(outbox.in_message());
  CHECK(batch(outbox) == Texts{"e1", "e2", "w2"});
  outbox.rewind();
  outbox.put(Delivery::latest, "world", bytes("w3"));
  CHECK(batch(outbox) == Texts{"e1", "e2", "w3"});
  CHECK(outbox.counters()["outbox.replaced.world"] == 2);
}

TEST_CASE("a full outbox drops the oldest ordered first") {
  // Room is made at the cost of old `ordered` messages, then of old `latest` ones, never of what is being written.
  const std::size_t each = 100 + Outbox::overhead_bytes;
  const auto message = [](char c) { return bytes(std::string(100, c)); };
  Outbox outbox(3 * each);
  outbox.put(Delivery::latest, "world", message('w'));
  outbox.put(Delivery::ordered, "events", message('1'));
  outbox.put(Delivery::ordered, "events", message('2'));
  CHECK(outbox.put(Delivery::ordered, "events", message('3')));
  CHECK(batch(outbox, 2) == Texts{std::string(100, 'w'), std::string(100, '2')});
  CHECK(outbox.counters()["outbox.dropped.full.events"] == 1);
  // The first two are being written: only the third can go.
  CHECK(outbox.put(Delivery::ordered, "events", message('4')));
  CHECK(outbox.put(Delivery::latest, "status", message('s')));
  CHECK(outbox.counters()["outbox.dropped.full.events"] == 3);
  CHECK(outbox.put(Delivery::latest, "other", message('o')));
  CHECK(outbox.counters()["outbox.dropped.full.status"] == 1);
  batch(outbox, 3);
  CHECK_FALSE(outbox.put(Delivery::ordered, "events", message('5')));
  CHECK(outbox.counters()["outbox.dropped.full.events"] == 4);
  CHECK(outbox.bytes() == 3 * each);
}

TEST_CASE("messages that are too long are refused") {
  // Nothing longer than the whole outbox, or than the peer takes, is kept, also when that is learnt later.
  Outbox outbox(1000);
  CHECK_FALSE(outbox.put(Delivery::latest, "world", bytes(std::string(1001 - Outbox::overhead_bytes, 'x'))));
  CHECK(outbox.put(Delivery::latest, "world", bytes(std::string(1000 - Outbox::overhead_bytes, 'x'))));
  CHECK(outbox.put(Delivery::latest, "world", bytes("short")));
  outbox.set_longest(4);
  CHECK(outbox.empty());
  CHECK(outbox.bytes() == 0);
  CHECK_FALSE(outbox.put(Delivery::latest, "world", bytes("12345")));
  CHECK(outbox.put(Delivery::latest, "world", bytes("1234")));
  CHECK(outbox.counters()["outbox.refused.too_big.world"] == 3);
}

TEST_CASE("a larger newer message takes its chance") {
  // When the newest no longer fits in the place of the older one, others make room for it, or it is dropped and
  // counted.
  Outbox outbox(2 * (100 + Outbox::overhead_bytes));
  outbox.put(Delivery::ordered, "events", bytes(std::string(100, 'e')));
  outbox.put(Delivery::latest, "world", bytes("w"));
  CHECK(outbox.put(Delivery::latest, "world", bytes(std::string(150, 'W'))));
  CHECK(batch(outbox) == Texts{std::string(150, 'W')});
  CHECK(outbox.counters()["outbox.dropped.full.events"] == 1);
  CHECK(outbox.counters()["outbox.replaced.world"] == 1);
}

TEST_CASE("batches keep their limits") {
  // A batch has at most so many messages and bytes, but a message that is larger goes alone.
  Outbox outbox(100'000);
  for (int i = 0; i < 10; ++i) outbox.put(Delivery::ordered, "events", bytes(std::string(100, 'x')));
  CHECK(outbox.batch(3, 10'000).size() == 3);
  CHECK(outbox.batch(100, 250).size() == 2);
  CHECK(outbox.batch(100, 50).size() == 1);
}

TEST_CASE("random use keeps the books") {
  // Over 200,000 random steps: the limit holds, everything put is written, replaced or dropped exactly once, in order
  // per channel, and the memory counted is that of what waits.
  hal::RandomStream random(7, "outbox_test");
  const std::size_t limit = 20'000;
  Outbox outbox(limit);
  const std::vector<std::pair<std::string, Delivery>> channels = {{"world", Delivery::latest},
                                                                  {"status", Delivery::latest},
                                                                  {"events", Delivery::ordered},
                                                                  {"log", Delivery::ordered}};
  std::uint64_t put = 0, written = 0, number = 0;
  std::map<std::string, std::uint64_t> newest_written;
  std::vector<std::string> handed_out;  // texts of the batch in hand, the first one as far as it is not written
  std::string partial;                  // what of the first message went before
  for (int step = 0; step < 200'000; ++step) {
    const auto chance = random.below(100);
    if (chance < 60) {
      const auto& [channel, delivery] = channels[random.below(channels.size())];
      std::string message = channel + " " + std::to_string(++number) + " ";
      message.resize(message.size() + random.below(random.below(20) == 0 ? 6000 : 300), 'x');
      ++put;
      outbox.put(delivery, channel, bytes(message));
    } else if (chance < 75) {
      handed_out = batch(outbox, 1 + random.below(20), 1 + random.below(4000));
    } else if (chance < 95 && !handed_out.empty()) {
      std::size_t all = 0;
      for (const std::string& each : handed_out) all += each.size();
      std::size_t taken = random.below(all + 1);
      const auto complete = outbox.written(taken);
      written += complete.messages;
      std::size_t messages = 0;
      for (std::string each : handed_out) {
        if (taken < each.size()) {
          partial += each.substr(0, taken);
          break;
        }
        taken -= each.size();
        each = partial + each;
        partial.clear();
        ++messages;
        const std::string channel = each.substr(0, each.find(' '));
        const std::uint64_t n = std::stoull(each.substr(each.find(' ') + 1));
        REQUIRE(n > newest_written[channel]);
        newest_written[channel] = n;
      }
      REQUIRE(messages == complete.messages);
      handed_out.clear();
    } else if (chance >= 98) {
      outbox.rewind();
      handed_out.clear();
      partial.clear();
    }
    REQUIRE(outbox.bytes() <= limit);
    REQUIRE(outbox.in_message() == !partial.empty());
  }
  std::uint64_t gone = 0;
  const hal::Counters counters = outbox.counters();
  for (const auto& [name, total] : counters.all()) gone += total;
  CHECK(put == written + gone + outbox.messages());
  CHECK(written > 1000);
  CHECK(gone > 1000);
  handed_out = batch(outbox, 100'000, 1 << 20);
  std::size_t waiting = 0;
  for (const std::string& each : handed_out) waiting += each.size() + Outbox::overhead_bytes;
  CHECK(outbox.bytes() == waiting + partial.size());
}

}  // namespace
}  // namespace arkmesh::gateway
