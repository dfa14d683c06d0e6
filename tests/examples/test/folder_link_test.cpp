// What the example's link does beside what every link does: its row, and a peer that dies without a word.
#include "tests/examples/folder_link.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
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

TEST_CASE("folder links: a peer that dies without a word is missed, and what it left deceives nobody") {
  // A killed gateway leaves its `alive` and its messages: the file is no sign of life because it does not change, and
  // the next gateway of the other lab does not take old messages for new ones. A damaged file is counted.
  const tests::TemporaryDirectory folder;
  const auto left = [&](const std::string& name, std::string_view text) {
    std::filesystem::create_directories(folder.path() / "shark" / "roark");
    std::ofstream(folder.path() / "shark" / "roark" / name) << text;
  };
  left("alive", "7 100\n");
  left("1-1.message", "old");
  boost::asio::io_context io;
  const examples::FolderLinkSettings settings{.lab = "shark",
                                              .peer = "roark",
                                              .boot_id = 1,
                                              .folder = folder.path(),
                                              .look_period = 5ms,
                                              .longest_silence = 1s};
  examples::FolderLink link(io, settings);
  int arrived = 0;
  link.start({.arrived = [&](std::string_view, std::span<const std::byte>) { ++arrived; }, .changed = {}});
  CHECK_FALSE(std::filesystem::exists(folder.path() / "shark" / "roark" / "1-1.message"));
  CHECK(link.stats().counters["received.dropped.before_start"] == 1);
  const auto begun = std::chrono::steady_clock::now();
  CHECK(run_until(io, [&] { return std::chrono::steady_clock::now() - begun > 300ms; }));
  CHECK_FALSE(link.stats().up);

  left("alive", "7 101\n");
  REQUIRE(run_until(io, [&] { return link.stats().up; }));
  CHECK(link.stats().peer_boot_id == 7);
  left("7-1.message", "no frame at all");
  CHECK(run_until(io, [&] { return link.stats().counters["received.refused.damaged"] == 1; }));
  CHECK(arrived == 0);
  REQUIRE(run_until(io, [&] { return !link.stats().up; }));
  CHECK(link.stats().why == "lab roark has been silent for 1 s");
}
