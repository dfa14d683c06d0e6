// What the example's link does beside what every link does: its row.
#include "tests/examples/folder_link.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "gateway/config.hpp"
#include "gateway/gateway.hpp"
#include "gateway/links/links.hpp"
#include "hal/bus/bus.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

namespace {

void add_row() {
  auto& kinds = gateway::link_kinds();
  if (std::ranges::find(kinds, "folder", &gateway::LinkKind::scheme) == kinds.end())
    kinds.push_back(examples::folder_links());
}

// The gateway of a lab on a bus of its own, as its configuration makes it.
struct Lab {
  hal::Bus bus{"memq://"};
  gateway::GatewayConfig config;
  gateway::Connections node;
  gateway::Gateway gateway;

  static gateway::GatewayConfig read(const std::string& name, const std::string& peer, const std::string& folder) {
    const hal::Config file = hal::Config::from_text(
        "[[gateway.peers]]\nlab = \"" + peer + "\"\nconnect = \"folder://" + folder + "\"\n", name + ".toml");
    return gateway::read_gateway_config(file.root().section("gateway"), name, {"roark", "shark"});
  }
  static std::vector<std::unique_ptr<gateway::Link>> one(std::unique_ptr<gateway::Link> link) {
    std::vector<std::unique_ptr<gateway::Link>> links;
    links.push_back(std::move(link));
    return links;
  }
  Lab(boost::asio::io_context& io, const std::string& name, const std::string& peer, const std::string& folder)
      : config(read(name, peer, folder)),
        node(io, {.lab = name, .boot_id = 1}),
        gateway(bus, name, 1, config.rules, one(gateway::make_link({io, node, name, 1, config}, config.peers.at(0)))) {
    gateway.start();
  }
};

template <class Condition>
bool run_until(boost::asio::io_context& io, Condition condition) {
  const auto deadline = std::chrono::steady_clock::now() + 300s;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    io.restart();
    io.run_one_for(5ms);
    io.poll();
  }
  return true;
}

}  // namespace

TEST_CASE("folder links: two gateways meet in the folder that their files name") {
  // What one lab publishes appears on the other's bus under its name, with nothing but configurations and a row.
  add_row();
  const tests::TemporaryDirectory folder;
  boost::asio::io_context io;
  Lab roark(io, "roark", "shark", folder.path().string()), shark(io, "shark", "roark", folder.path().string());
  std::string heard;
  const auto subscription = shark.bus.subscribe(
      "roark/world", [&](std::string_view channel, std::span<const std::byte>) { heard = channel; });
  REQUIRE(run_until(io, [&] { return roark.gateway.links()[0]->stats().up && shark.gateway.links()[0]->stats().up; }));
  roark.bus.publish("world", std::vector<std::byte>(100));
  CHECK(run_until(io, [&] {
    roark.bus.drain();
    shark.bus.drain();
    return heard == "roark/world";
  }));
}

TEST_CASE("folder links: a file that names no folder is refused") {
  // The sentence names the key, and that of another scheme names the new row, too.
  add_row();
  CHECK_THROWS_WITH_AS(
      Lab::read("roark", "shark", "shared"),
      "roark.toml:3: gateway.peers[0].connect = \"folder://shared\": must be folder:// and an absolute "
      "path",
      hal::ConfigError);
  CHECK(
      gateway::why_not_connectable("ftp://x") ==
      "begins with 'ftp://', which is not a kind of link; there are: tcp://, tls://, nats://, tls+nats://, folder://");
}
