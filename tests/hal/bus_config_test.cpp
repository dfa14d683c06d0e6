// What [bus] of a lab's file may say, and how its URL is read.
#include "hal/bus/bus_config.hpp"

#include <arpa/inet.h>
#include <doctest/doctest.h>

#include <string>

#include "hal/bus/multicast_url.hpp"

namespace arkmesh::hal {
namespace {

BusConfig read_bus(const std::string& keys) {
  return Config::from_text("[bus]\n" + keys, "lab.toml").root().section("bus").read<BusConfig>();
}

TEST_CASE("bus: hosts to hear are addresses, and only a bus that leaves the machine has any") {
  // Anything else is refused with the key and what to write.
  const std::string network = "url = \"udpm://239.255.76.67:7701?ttl=1\"\n", machine = "url = \"udpm://?ttl=0\"\n";
  CHECK(read_bus(network + "hear = [\"10.0.0.5\", \"10.0.0.6\"]").hear.size() == 2);
  CHECK(read_bus(machine).hear.empty());
  CHECK_THROWS_WITH_AS(read_bus(network + "hear = [\"roark\"]"), doctest::Contains("'roark' is not an IPv4 address"),
                       ConfigError);
  CHECK_THROWS_WITH_AS(read_bus(machine + "hear = [\"10.0.0.5\"]"), doctest::Contains("write ttl=1 in bus.url"),
                       ConfigError);
  std::string many = network + "hear = [\"10.0.0.5\"";
  for (int i = 0; i < 250; ++i) many += ", \"10.0.0.6\"";
  CHECK_THROWS_WITH_AS(read_bus(many + "]"), doctest::Contains("names 251 hosts; at most 250 are possible"),
                       ConfigError);
}

TEST_CASE("bus: an LCM URL is read as LCM reads it") {
  // LCM's group and port where the URL has none, numbers of any base, the last of two values.
  const MulticastUrl lcm("udpm://");
  CHECK(lcm.group.sin_addr.s_addr == inet_addr("239.255.76.67"));
  CHECK(ntohs(lcm.group.sin_port) == 7667);
  CHECK(lcm.ttl == 0);
  CHECK(lcm.receive_buffer_bytes == 4 << 20);
  const MulticastUrl own("udpm://239.1.2.3:7701?ttl=0&recv_buf_size=0x1000&ttl=1");
  CHECK(own.group.sin_addr.s_addr == inet_addr("239.1.2.3"));
  CHECK(ntohs(own.group.sin_port) == 7701);
  CHECK(own.ttl == 1);
  CHECK(own.receive_buffer_bytes == 4096);
}

}  // namespace
}  // namespace arkmesh::hal
