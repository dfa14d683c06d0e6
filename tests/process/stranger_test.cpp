// What a lab's bus hears of other hosts of its network: nothing, or those that are named.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "hal/bus/bus.hpp"
#include "tests/support/network/lcm_datagrams.hpp"
#include "tests/support/network/two_hosts.hpp"
#include "tests/support/processes/process.hpp"

namespace {

using namespace arkmesh;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

constexpr const char* group = "239.255.76.67";
constexpr int bus_port = 7820;

// A bus of the lab's host and what it hears.
struct Listening {
  hal::Bus bus;
  std::vector<std::string> heard;
  std::unique_ptr<hal::Bus::Subscription> all;

  Listening(const TwoHosts& hosts, int ttl, const std::vector<std::string>& hear = {})
      : Listening(Inside(hosts.lab_host()), ttl, hear) {}
  Listening(const Inside&, int ttl, const std::vector<std::string>& hear)
      : bus(fmt::format("udpm://{}:{}?ttl={}", group, bus_port, ttl), hear),
        all(bus.subscribe(".*", [this](std::string_view channel, auto) { heard.emplace_back(channel); })) {}
  std::uint64_t refused() { return bus.counters()["refused.stranger"]; }
  bool hears(const std::string& channel) {
    return eventually(300s, [&] {
      bus.drain(10ms);
      return std::ranges::find(heard, channel) != heard.end();
    });
  }
  bool refuses(std::uint64_t number) {
    return eventually(300s, [&] { return refused() >= number; });
  }
};

}  // namespace

TEST_CASE("a bus of this machine hears this machine only") {
  // Its own multicast, whichever device the route names; not what another host sends to the group or to this machine,
  // not even under this machine's address; and no unicast of its own.
  const TwoHosts hosts;
  for (const char* device : {"lab0", "lo"}) {
    CAPTURE(device);
    REQUIRE(run_in(hosts.lab_host(), fmt::format("ip route replace 224.0.0.0/4 dev {}", device)));
    Listening lab(hosts, 0);
    lab.bus.publish("own", {});
    CHECK(lab.hears("own"));

    const bool by_network = device == std::string("lab0");  // a group joined on lo hears nothing from the network
    REQUIRE(run_in(hosts.stranger_host(), "ip addr add 10.9.0.1/32 dev str0"));
    const UdpSender stranger(hosts.stranger_host(), "10.9.0.2"), forger(hosts.stranger_host(), "10.9.0.1");
    stranger.send(short_datagram("multicast", ""), group, bus_port);
    forger.send(short_datagram("forged", ""), group, bus_port);
    CHECK(lab.refuses(by_network ? 1 : 0));
    REQUIRE(run_in(hosts.stranger_host(), "ip addr del 10.9.0.1/32 dev str0"));
    const std::uint64_t before = lab.refused();
    stranger.send(short_datagram("unicast", ""), "10.9.0.1", bus_port);
    const UdpSender local(hosts.lab_host(), "10.9.0.1");
    local.send(short_datagram("local unicast", ""), "127.0.0.1", bus_port);
    CHECK(lab.refuses(before + 2));

    lab.bus.publish("last", std::vector<std::byte>(100'000));
    CHECK(lab.hears("last"));
    CHECK(lab.heard == std::vector<std::string>{"own", "last"});
  }
}

TEST_CASE("a bus of several machines hears those that are named") {
  // And no unicast of theirs.
  const TwoHosts hosts;
  Listening lab(hosts, 1, {"10.9.0.77", "10.9.0.2"});
  const UdpSender friendly(hosts.stranger_host(), "10.9.0.2"), stranger(hosts.stranger_host(), "10.9.0.3");
  stranger.send(short_datagram("stranger", ""), group, bus_port);
  friendly.send(short_datagram("unicast", ""), "10.9.0.1", bus_port);
  CHECK(lab.refuses(2));
  friendly.send(short_datagram("friendly", ""), group, bus_port);
  CHECK(lab.hears("friendly"));
  lab.bus.publish("own", {});
  CHECK(lab.hears("own"));
  CHECK(lab.heard == std::vector<std::string>{"friendly", "own"});
}
