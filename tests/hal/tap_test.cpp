// The tap between two buses in memory. A memq bus hears its own messages, as multicast does.
#include "hal/bus/tap.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace arkmesh::hal;

namespace {

struct Heard {
  std::vector<std::string> channels;
  std::unique_ptr<Bus::Subscription> subscription;
  explicit Heard(Bus& bus)
      : subscription(bus.subscribe(".*", [this](std::string_view channel, auto) { channels.emplace_back(channel); })) {}
};

// Until neither bus has anything to deliver; false when they never come to rest.
bool settle(Bus& a, Bus& b) {
  for (int round = 0; round < 100; ++round)
    if (a.drain() + b.drain() == 0) return true;
  return false;
}

}  // namespace

TEST_CASE("own messages go out, wanted ones come in, nothing goes round") {
  // Own channels leave once and do not come back; what came in does not leave again; unwanted names stay outside.
  Bus inside("memq://"), outside("memq://");
  Heard inner(inside), outer(outside);
  Tap tap(inside, outside, {"[^/]+/world", "[^/]+/status", "peers", "fleet_command"});
  inside.publish("poses", {});
  inside.publish("world", {});
  CHECK(settle(inside, outside));
  CHECK(inner.channels == std::vector<std::string>{"poses", "world"});
  CHECK(outer.channels == std::vector<std::string>{"poses", "world"});

  inner.channels.clear(), outer.channels.clear();
  outside.publish("roark/world", {});
  outside.publish("roark/poses", {});
  outside.publish("peers", {});
  outside.publish("to_robots", {});
  CHECK(settle(inside, outside));
  CHECK(inner.channels == std::vector<std::string>{"roark/world", "peers"});
  CHECK(outer.channels == std::vector<std::string>{"roark/world", "roark/poses", "peers", "to_robots"});
}

TEST_CASE("the bytes pass unchanged in both directions") {
  // Empty, small and large messages.
  Bus inside("memq://"), outside("memq://");
  Tap tap(inside, outside, {"in"});
  std::vector<std::size_t> in, out;
  const auto a = inside.subscribe("in", [&](auto, std::span<const std::byte> bytes) {
    in.push_back(bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) CHECK(bytes[i] == static_cast<std::byte>(i));
  });
  const auto b = outside.subscribe("out", [&](auto, std::span<const std::byte> bytes) { out.push_back(bytes.size()); });
  for (std::size_t size : {0, 1, 1000}) {
    std::vector<std::byte> bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i);
    outside.publish("in", bytes);
    inside.publish("out", bytes);
  }
  CHECK(settle(inside, outside));
  CHECK(in == std::vector<std::size_t>{0, 1, 1000});
  CHECK(out == in);
}

TEST_CASE("messages leave during the private drain") {
  // No queue of the tap's own holds them back, and a tap that died copies nothing.
  Bus inside("memq://"), outside("memq://");
  Heard outer(outside);
  auto tap = std::make_unique<Tap>(inside, outside, std::vector<std::string>{});
  inside.publish("poses", {});
  inside.drain();
  CHECK(outside.drain() == 1);
  tap.reset();
  inside.publish("poses", {});
  inside.drain();
  CHECK(outside.drain() == 0);
}
