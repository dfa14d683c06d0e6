// How many packets of a lab are looked at: rates, in the time of the test.
#include "gateway/federation/packet_keys.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <string>
#include <vector>

#include "tests/support/network/test_keys.hpp"

namespace arkmesh::gateway {
namespace {

using namespace std::chrono_literals;

// shark, and two labs that it trusts.
struct Trusted {
  tests::TestKeys keys;
  PacketKeys::Time now{1h};

  Trusted() {
    for (const char* lab : {"roark", "mole"}) keys.join("shark", lab);
  }
  PacketKeys of(const std::string& lab) const { return {lab, "dhtf", 1, keys.tls(lab)}; }
};

TEST_CASE("of a lab's own packets 5000 a second are looked at, and no more") {
  // A second's worth at once, then as many as time brings; another lab's are looked at meanwhile.
  Trusted labs;
  PacketKeys shark = labs.of("shark"), roark = labs.of("roark"), mole = labs.of("mole");
  const std::vector<std::byte> body(100, std::byte{'!'});
  const auto sealed = mole.for_one("shark", body).value(), signed_one = mole.for_all(PacketKind::signed_open, body),
             of_roark = roark.for_one("shark", body).value();
  const PacketView own = read_packet(sealed).value(), for_all = read_packet(signed_one).value();
  for (int i = 0; i < 4900; ++i) REQUIRE(shark.open(own, labs.now) == body);
  for (int i = 0; i < 100; ++i) REQUIRE((shark.open(for_all, labs.now) == body && shark.is_signed(for_all, labs.now)));
  for (int i = 0; i < 1000; ++i) REQUIRE_FALSE(shark.open(i % 2 == 0 ? own : for_all, labs.now));
  CHECK(shark.counters()["federation.refused.too_many.mole"] == 1000);
  CHECK(shark.open(read_packet(of_roark).value(), labs.now) == body);
  CHECK(shark.counters()["federation.refused.too_many.roark"] == 0);
  for (const auto& [later, looked_at] : {std::pair(10ms, 50), std::pair(10'000ms, 5000)}) {
    labs.now += later;
    int n = 0;
    for (int i = 0; i < 5500; ++i) n += shark.open(own, labs.now).has_value();
    CHECK(n == looked_at);
  }
}

TEST_CASE("of packets that a lab has not signed 20 a second are looked at, and no more") {
  Trusted labs;
  PacketKeys shark = labs.of("shark"), mole = labs.of("mole");
  auto forged = mole.for_all(PacketKind::signed_open, std::vector<std::byte>(100, std::byte{'!'}));
  forged.back() ^= std::byte{1};
  const PacketView packet = read_packet(forged).value();
  for (std::uint64_t second = 1; second <= 3; ++second) {
    for (int i = 0; i < 100; ++i) CHECK_FALSE(shark.is_signed(packet, labs.now));
    CHECK(shark.counters()["federation.refused.signature.mole"] == 20 * second);
    CHECK(shark.counters()["federation.refused.too_many_forged.mole"] == 80 * second);
    labs.now += 1s;
  }
}

}  // namespace
}  // namespace arkmesh::gateway
