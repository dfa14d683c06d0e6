// What a result tells of the links: of the lab's peers, whoever writes on its bus.
#include "app/live/traffic_monitor.hpp"

#include <doctest/doctest.h>

#include <array>
#include <string>

#include "arkmesh/peers_t.hpp"
#include "hal/arenas/messages.hpp"

using namespace arkmesh;

TEST_CASE("traffic: names that are no peer's are not told") {
  hal::Bus bus("memq://");
  const app::TrafficMonitor monitor(bus, {"roark", "shark"});
  const std::array<std::byte, 10> bytes{};
  peers_t links{};
  links.lab = "shark";
  links.n_peers = 50;
  links.peers.resize(50);
  for (int i = 0; i < 50; ++i) {
    bus.publish("x" + std::to_string(i) + "/status", bytes);
    links.peers[static_cast<std::size_t>(i)].lab = "y" + std::to_string(i);
  }
  links.peers[0].lab = "roark";
  links.peers[0].version = "0.1.0";
  bus.publish("roark/world", bytes);
  bus.publish(hal::channel::peers, links);
  bus.drain();
  REQUIRE(monitor.by_peer().size() == 1);
  CHECK(monitor.by_peer().at("roark").received_bytes == 10);
  CHECK(monitor.by_peer().at("roark").version == "0.1.0");
}
