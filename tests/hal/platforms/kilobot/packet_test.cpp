// Packets byte by byte against worked examples, and which of them may follow each other.
#include "hal/platforms/kilobot/packet.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "hal/random.hpp"
#include "tests/support/kilobot/packet_ear.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using arkmesh::tests::PacketEar;

namespace {

Message message(std::uint8_t type, std::array<std::uint8_t, 9> data = {}) {
  Message out{data, type, 0};
  out.crc = message_crc(out);
  return out;
}

std::array<std::uint8_t, page_bytes> counting_page() {
  std::array<std::uint8_t, page_bytes> out;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(i);
  return out;
}

// A packet of any type with payload bytes from a small set, so that headers and equal sums come up often.
Packet any_packet(hal::RandomStream& random) {
  const std::array<std::uint8_t, 8> bytes{0, 0, 1, 2, 3, 0x55, 0x55, 0x54};
  const auto pick = [&] { return bytes[random.below(bytes.size())]; };
  Message content;
  for (auto& byte : content.data) byte = pick();
  content.type = pick();
  content.crc = message_crc(content);
  std::array<std::uint8_t, page_bytes> page;
  for (auto& byte : page) byte = pick();
  switch (random.below(6)) {
    case 0:
      return led_toggle_packet();
    case 1:
      return forward_packet(content);
    case 2:
      return forward_once_packet(content);
    case 3:
      return forward_raw_packet(content);
    case 4:
      return boot_page_packet(pick(), page);
    default:
      return stop_packet();
  }
}

}  // namespace

TEST_CASE("packet: worked examples") {
  // Every packet that has a worked example has its first 12 bytes and its checksum.
  struct Example {
    std::string name;
    Packet packet;
    std::vector<std::uint8_t> begin;
    std::uint8_t checksum;
  };
  const std::vector<Example> examples{
      {"stop", stop_packet(), {0x55, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 0x55},
      {"lamp", led_toggle_packet(), {0x55, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 0x54},
      {"run", forward_packet(message(type_run)), {0x55, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x88}, 0xDF},
      {"reset", forward_packet(message(type_reset)), {0x55, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x83}, 0xD4},
      {"sleep", forward_packet(message(type_sleep)), {0x55, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x84}, 0xD3},
      {"wake", forward_packet(message(type_wakeup)), {0x55, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x85}, 0xD2},
      {"charge", forward_packet(message(type_charge)), {0x55, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x86}, 0xD1},
      {"voltage", forward_packet(message(type_voltage)), {0x55, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x87}, 0xD0},
      {"boot", forward_packet(message(type_boot)), {0x55, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x80}, 0xD7},
      {"read bit 3 of the id",
       forward_packet(message(type_read_uid, {3})),
       {0x55, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0x89},
       0xDD},
      {"17 pages", forward_packet(message(type_boot_size, {17})), {0x55, 2, 0x11, 0, 0, 0, 0, 0, 0, 0, 0, 0x82}, 0xC4},
      {"set id 300",
       forward_packet(message(type_calibrate, {1, 0x2C, 1})),
       {0x55, 2, 1, 0x2C, 1, 0, 0, 0, 0, 0, 0, 0x8A},
       0xF1},
      {"left 72",
       forward_packet(message(type_calibrate, {2, 0, 0, 72})),
       {0x55, 2, 2, 0, 0, 0x48, 0, 0, 0, 0, 0, 0x8A},
       0x97},
      {"right 74",
       forward_packet(message(type_calibrate, {3, 0, 0, 0, 74})),
       {0x55, 2, 3, 0, 0, 0, 0x4A, 0, 0, 0, 0, 0x8A},
       0x94},
      {"straight",
       forward_packet(message(type_calibrate, {4, 0, 0, 0, 0, 65, 70})),
       {0x55, 2, 4, 0, 0, 0, 0, 0x41, 0x46, 0, 0, 0x8A},
       0xDE},
      {"save", forward_packet(message(type_calibrate)), {0x55, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x8A}, 0xDD},
      {"page 7", boot_page_packet(7, counting_page()), {0x55, 4, 7, 0, 1, 2, 3, 4, 5, 6, 7, 8}, 0x56},
      {"composite",
       forward_packet(message(0, {1, 0x45, 0x2C, 0xFA, 0x3B, 0xFF, 0xFF, 0xC0, 0})),
       {0x55, 2, 1, 0x45, 0x2C, 0xFA, 0x3B, 0xFF, 0xFF, 0xC0, 0, 0},
       0x3E},
  };
  for (const Example& example : examples) {
    CAPTURE(example.name);
    CHECK(std::ranges::equal(std::span(example.packet).first(12), example.begin));
    CHECK(example.packet.back() == example.checksum);
    CHECK(is_packet(example.packet));
    if (example.name != "page 7") CHECK(std::ranges::count(std::span(example.packet).subspan(12, 119), 0) == 119);
  }
}

TEST_CASE("packet: checksum of the message") {
  // A raw packet carries the message's own checksum, low byte first; the others leave it to the controller.
  const Message run = message(type_run);
  const Packet raw = forward_raw_packet(run), plain = forward_packet(run), once = forward_once_packet(run);
  CHECK(raw[1] == 3);
  CHECK(raw[12] == 0xC7);
  CHECK(raw[13] == 0x94);
  CHECK(is_packet(raw));
  CHECK(plain[12] == 0);
  CHECK(once[1] == 6);
  CHECK(is_packet(once));
}

TEST_CASE("packet: a changed bit") {
  // No single changed bit leaves a packet a packet.
  const Packet good = boot_page_packet(7, counting_page());
  for (std::size_t i = 0; i < packet_bytes; ++i)
    for (int bit = 0; bit < 8; ++bit) {
      Packet bad = good;
      bad[i] ^= static_cast<std::uint8_t>(1 << bit);
      CHECK_FALSE(is_packet(bad));
    }
}

TEST_CASE("packet: false packet between two equal ones") {
  // The known case: a payload with the header byte sent twice is taken for a lamp command between the two.
  const Packet packet = forward_packet(message(0, {0, 0, 0, 0x55, 1}));
  const auto offset = false_packet_between(packet, packet);
  REQUIRE(offset);
  CHECK(*offset == 5);
  PacketEar ear;
  ear.hear(packet);
  const auto heard = ear.hear(packet);
  REQUIRE(heard.size() == 2);
  CHECK(heard[0][1] == static_cast<std::uint8_t>(PacketType::led_toggle));
  CHECK(heard[1] == packet);
  CHECK_FALSE(false_packet_between(forward_packet(message(type_run)), forward_packet(message(type_reset))));
}

TEST_CASE("packet: false packets are those that a controller hears") {
  // The test agrees with a controller's ear for thousands of pairs, dangerous and not, and a parting stop makes each
  // pair safe.
  hal::RandomStream random(1, "packets");
  int dangerous = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Packet first = any_packet(random), second = random.below(4) == 0 ? first : any_packet(random);
    PacketEar ear;
    ear.hear(first);
    const auto heard = ear.hear(second);
    REQUIRE(!heard.empty());
    REQUIRE(heard.back() == second);
    REQUIRE(false_packet_between(first, second).has_value() == (heard.size() > 1));
    if (heard.size() == 1) continue;
    ++dangerous;
    const Packet stop = parting_stop(first, second);
    PacketEar careful;
    careful.hear(first);
    REQUIRE(careful.hear(stop) == std::vector{stop});
    REQUIRE(careful.hear(second) == std::vector{second});
  }
  CHECK(dangerous > 1000);
}
