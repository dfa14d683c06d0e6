// The bus in memory. Over the network: tests/process/hal_bus_test.cpp.
#include "hal/bus/bus.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "hal/arenas/messages.hpp"

using namespace arkmesh;
using namespace arkmesh::hal;

namespace {

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

// Keeps "channel=text" of all it hears.
struct Listener {
  std::vector<std::string> heard;
  Bus::Handler handler() {
    return [this](std::string_view channel, std::span<const std::byte> bytes) {
      heard.push_back(std::string(channel) + "=" +
                      std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    };
  }
};

}  // namespace

TEST_CASE("messages arrive in order, unchanged, at every subscription that matches") {
  // One anchored pattern, one alternative, one wildcard; nothing is delivered before drain().
  Bus bus("memq://");
  Listener world, either, all;
  const auto a = bus.subscribe("[^/]+/world", world.handler());
  const auto b = bus.subscribe("poses|peers", either.handler());
  const auto c = bus.subscribe(".*", all.handler());
  bus.publish("roark/world", bytes_of("1"));
  bus.publish("poses", bytes_of("2"));
  bus.publish("world", bytes_of("3"));
  bus.publish("poses_of_mine", bytes_of("4"));
  bus.publish("my_peers", {});
  CHECK(all.heard.empty());
  CHECK(bus.drain() == 5);
  CHECK(world.heard == std::vector<std::string>{"roark/world=1"});
  CHECK(either.heard == std::vector<std::string>{"poses=2"});
  CHECK(all.heard == std::vector<std::string>{"roark/world=1", "poses=2", "world=3", "poses_of_mine=4", "my_peers="});
  CHECK(bus.drain() == 0);
}

TEST_CASE("nothing is lost however much waits") {
  // LCM's default queue holds 30 messages; here 20000 wait at once.
  Bus bus("memq://");
  int heard = 0;
  const auto subscription = bus.subscribe("x", [&](auto, auto) { ++heard; });
  for (int i = 0; i < 20'000; ++i) bus.publish("x", bytes_of("m"));
  CHECK(bus.drain() == 20'000);
  CHECK(heard == 20'000);
}

TEST_CASE("what handlers publish is delivered in the same drain") {
  // A chain of 1000 answers comes to its end, and messages without subscribers do not count.
  Bus bus("memq://");
  int last = -1;
  const auto subscription = bus.subscribe("x", [&](std::string_view, std::span<const std::byte> bytes) {
    last = static_cast<int>(bytes.size());
    if (last < 1000) bus.publish("x", std::vector<std::byte>(bytes.size() + 1));
    bus.publish("nobody", bytes_of("?"));
  });
  bus.publish("x", {});
  CHECK(bus.drain() == 1001);
  CHECK(last == 1000);
}

TEST_CASE("a handler is not called after its subscription died") {
  // Neither for messages that waited already, nor when it dies inside itself or inside another handler of that message.
  Bus bus("memq://");
  Listener listener;
  auto first = bus.subscribe("x", listener.handler());
  bus.publish("x", bytes_of("waiting"));
  first.reset();
  CHECK(bus.drain() == 0);
  CHECK(listener.heard.empty());

  int own = 0, other = 0;
  std::unique_ptr<Bus::Subscription> self, victim, killer;
  self = bus.subscribe("y", [&](auto, auto) {
    ++own;
    self.reset();
  });
  killer = bus.subscribe("y", [&](auto, auto) { victim.reset(); });
  victim = bus.subscribe("y", [&](auto, auto) { ++other; });
  for (int i = 0; i < 3; ++i) bus.publish("y", bytes_of("m"));
  bus.drain();
  CHECK(own == 1);
  CHECK(other == 0);
}

TEST_CASE("a handler may subscribe") {
  // The new subscription hears the messages after the one in hand.
  Bus bus("memq://");
  Listener late;
  std::unique_ptr<Bus::Subscription> added;
  const auto first = bus.subscribe("x", [&](auto, auto) {
    if (!added) added = bus.subscribe("x", late.handler());
  });
  bus.publish("x", bytes_of("1"));
  bus.publish("x", bytes_of("2"));
  bus.drain();
  CHECK(late.heard == std::vector<std::string>{"x=2"});
}

TEST_CASE("a handler's exception comes out of drain and loses no other message") {
  // The first is thrown after its message is done with; the rest waits for the next drain.
  Bus bus("memq://");
  Listener listener;
  const auto thrower = bus.subscribe("bad", [](auto, auto) { throw std::runtime_error("no good"); });
  const auto hearer = bus.subscribe(".*", listener.handler());
  bus.publish("bad", bytes_of("1"));
  bus.publish("good", bytes_of("2"));
  CHECK_THROWS_WITH(bus.drain(), "no good");
  CHECK(bus.drain() == 1);
  CHECK(listener.heard == std::vector<std::string>{"bad=1", "good=2"});
}

TEST_CASE("bus and subscriptions may die in any order") {
  // A handle that outlives its bus does nothing when it dies.
  auto bus = std::make_unique<Bus>("memq://");
  auto subscription = bus->subscribe("x", [](auto, auto) {});
  bus->publish("x", bytes_of("1"));
  bus.reset();
  subscription.reset();
  CHECK(!subscription);
}

TEST_CASE("channel names that LCM cannot carry are refused and counted") {
  // 63 bytes are allowed; more, none, or a zero byte inside are not.
  Bus bus("memq://");
  Listener all;
  const auto subscription = bus.subscribe(".*", all.handler());
  bus.publish(std::string(63, 'c'), {});
  CHECK(bus.counters()["refused.channel_name"] == 0);
  bus.publish(std::string(64, 'c'), {});
  bus.publish("", {});
  bus.publish(std::string("a\0b", 3), {});
  CHECK(bus.counters()["refused.channel_name"] == 3);
  CHECK(bus.drain() == 1);
}

TEST_CASE("bad URLs and patterns are refused in one sentence") {
  // Including LCM's other transports, which lose messages or end the process.
  for (const char* url : {"", "tcpq://127.0.0.1:7700", "file:///tmp/x", "memq:/", "udpm:"}) {
    CAPTURE(url);
    CHECK_THROWS_WITH_AS(Bus{url}, doctest::Contains("must be memq:// or udpm://"), std::runtime_error);
  }
  CHECK_THROWS_WITH_AS(Bus{"udpm://nowhere:1"}, doctest::Contains("LCM cannot open it"), std::runtime_error);
  Bus bus("memq://");
  CHECK_THROWS_WITH_AS(static_cast<void>(bus.subscribe("(", [](auto, auto) {})), "'(' is not a channel pattern",
                       std::runtime_error);
}

TEST_CASE("nobody else publishes in memory, so that there is nothing to wait for") {
  Bus bus("memq://");
  Listener all;
  const auto subscription = bus.subscribe(".*", all.handler());
  CHECK(bus.drain(std::chrono::hours{1}) == 0);
  bus.publish("x", {});
  CHECK(bus.drain(std::chrono::hours{1}) == 1);
}

TEST_CASE("large messages and many keep their order and their bytes") {
  // More than LCM is given at once, with small ones between them, and what handlers publish meanwhile behind them.
  Bus bus("memq://");
  std::vector<std::size_t> heard;
  const auto subscription = bus.subscribe("x|y", [&](std::string_view channel, std::span<const std::byte> bytes) {
    heard.push_back(bytes.size());
    CHECK(std::ranges::all_of(bytes, [&](std::byte b) { return b == static_cast<std::byte>(bytes.size() & 0xff); }));
    if (channel == "x") bus.publish("y", std::vector<std::byte>(1, std::byte{1}));
  });
  std::vector<std::size_t> sent;
  for (int i = 0; i < 50; ++i) {
    const std::size_t size = i % 3 == 0 ? 1'000'000 + static_cast<std::size_t>(i) : static_cast<std::size_t>(i);
    sent.push_back(size);
    bus.publish("x", std::vector<std::byte>(size, static_cast<std::byte>(size & 0xff)));
  }
  CHECK(bus.drain() == 100);
  // what was published while the first ones were handed out may stand between those that LCM had not got by then
  std::erase(heard, 1U);
  std::erase(sent, 1U);
  CHECK(heard == sent);
}

TEST_CASE("typed messages are published and decoded, anything else is not decoded") {
  // Cut, lengthened and foreign bytes give false and no exception.
  Bus bus("memq://");
  std::vector<std::byte> last;
  const auto subscription =
      bus.subscribe("poses", [&](auto, std::span<const std::byte> bytes) { last.assign(bytes.begin(), bytes.end()); });
  PoseFrame frame;
  frame.number = 7;
  frame.robots = {{3, {0.1, -0.2, 0.3}, Led::green, 0.5F, LabTime{42}}};
  bus.publish("poses", to_messages(frame).front());
  CHECK(bus.drain() == 1);
  pose_frame_t message;
  REQUIRE(decode(last, message));
  CHECK(message.number == 7);
  CHECK(message.robots.at(0).x_m == 0.1);
  for (std::size_t length = 0; length < last.size(); ++length)
    CHECK_FALSE(decode(std::span<const std::byte>(last).first(length), message));
  to_robots_t other;
  CHECK_FALSE(decode(last, other));
  last.push_back({});
  CHECK_FALSE(decode(last, message));
}
