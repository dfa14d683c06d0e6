// The controller's device against the measurements of the published firmware.
#include "emulator/ohc_device.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <set>
#include <vector>

using namespace arkmesh;
using emulator::OhcDevice;
using sim_ode::Transmission;
using Packet = std::array<std::uint8_t, OhcDevice::packet_bytes>;

namespace {

constexpr std::int64_t started_us = 2'000'000, packet_us = 34'375;

Packet packet(std::uint8_t type, std::initializer_list<int> bytes, std::uint8_t message_type = 0) {
  Packet out{};
  out[0] = 0x55;
  out[1] = type;
  std::size_t k = 2;
  for (int byte : bytes) out[k++] = static_cast<std::uint8_t>(byte);
  if (message_type != 0) out[11] = message_type;
  for (std::size_t i = 0; i + 1 < out.size(); ++i) out[131] ^= out[i];
  return out;
}

// The bytes of a packet one after the other, each ready `byte_us` after the one before; returns when the last was.
std::int64_t write(OhcDevice& device, const Packet& packet, std::int64_t from_us, double byte_us = 3125 / 12.0) {
  std::int64_t at = from_us;
  for (std::size_t i = 0; i < packet.size(); ++i) {
    at = from_us + static_cast<std::int64_t>(byte_us * static_cast<double>(i + 1));
    device.receive(packet[i], at);
  }
  return at;
}

std::vector<Transmission> heard(OhcDevice& device, std::int64_t until_us) {
  std::vector<Transmission> out;
  device.sent_until(until_us, out);
  return out;
}

struct Copies {
  double with_one = 0, mean = 0;
  std::size_t least = 1000, most = 0;
};

// A stream of packets, each with a message of its own and without 0x55 in it, from start to start `spacing_us`.
Copies stream(std::uint8_t type, std::int64_t spacing_us, double byte_us = 3125 / 12.0) {
  constexpr int packets = 4000;
  OhcDevice device;
  std::vector<std::size_t> copies(packets);
  for (int k = 0; k < packets; ++k) {
    const std::int64_t end =
        write(device, packet(type, {k & 0x3F, k >> 6}, 2), started_us + 10'000 + k * spacing_us, byte_us);
    for (const Transmission& sent : heard(device, end + (k + 1 == packets ? 20'000 : 0)))
      if (sent.clean) ++copies[static_cast<std::size_t>(sent.message.data[0] | sent.message.data[1] << 6)];
  }
  Copies out;
  // the last one is followed by nothing
  for (int k = 0; k + 1 < packets; ++k) {
    const std::size_t n = copies[static_cast<std::size_t>(k)];
    out.with_one += n > 0;
    out.mean += static_cast<double>(n);
    out.least = std::min(out.least, n);
    out.most = std::max(out.most, n);
  }
  out.with_one /= packets - 1;
  out.mean /= packets - 1;
  return out;
}

}  // namespace

TEST_CASE("a forwarded message is repeated each 10.409 ms with a checksum of the device's own, until the next packet") {
  // The published example of RUN, its latency of 0.2 ms, 96 messages a second of 4.37 ms, and STOP.
  OhcDevice device;
  const Packet run = packet(2, {}, 0x88);
  CHECK(run[131] == 0xDF);
  const std::int64_t end = write(device, run, started_us);
  CHECK(end == started_us + packet_us);
  const auto sent = heard(device, end + 1'000'000);
  REQUIRE(sent.size() == 96);
  CHECK(sent[0].start_us == end + 200);
  for (std::size_t k = 0; k < sent.size(); ++k) {
    CHECK(sent[k].clean);
    CHECK(sent[k].start_us == sent[0].start_us + static_cast<std::int64_t>(k) * 10'409);
    CHECK(sent[k].end_us - sent[k].start_us == 4371);
    CHECK(sent[k].message.type == 0x88);
    CHECK(sent[k].message.crc == 0x94C7);
  }
  const std::int64_t stopped = write(device, packet(0, {}), end + 1'000'000);
  heard(device, stopped + 10'609);
  CHECK(heard(device, stopped + 5'000'000).empty());
  CHECK(device.counters()["ohc.packets.stop"] == 1);
}

TEST_CASE("how many copies of a packet stay clean depends on the spacing as measured on the firmware") {
  // Table: start-to-start spacing, share of packets with a clean copy and clean copies per packet for type 2, and for
  // type 6.
  struct Row {
    int spacing_ms;
    double with_one, mean;
    std::size_t least, most;
    double single;
  };
  const Row rows[] = {{35, 0, 0, 0, 0, 0},     {36, 0, 0, 0, 0, 0},     {38, 0, 0, 0, 0, 0},
                      {40, .14, .14, 0, 1, 1}, {42, .31, .31, 0, 1, 1}, {45, .61, .61, 0, 1, 1},
                      {47, .80, .80, 0, 1, 1}, {50, 1, 1.10, 1, 2, 1},  {55, 1, 1.6, 1, 2, 1},
                      {60, 1, 2.1, 2, 3, 1},   {70, 1, 3.0, 3, 4, 1},   {80, 1, 4.0, 3, 4, 1},
                      {100, 1, 5.9, 5, 6, 1}};
  for (const Row& row : rows) {
    CAPTURE(row.spacing_ms);
    const Copies repeated = stream(2, row.spacing_ms * 1000), single = stream(6, row.spacing_ms * 1000);
    CHECK(std::abs(repeated.with_one - row.with_one) < 0.02);
    CHECK(std::abs(repeated.mean - row.mean) < 0.1);
    CHECK(repeated.most <= row.most);
    CHECK(single.with_one == row.single);
    CHECK(single.mean == row.single);
    CHECK(repeated.least >= row.least);
  }
  // bytes 10 % farther apart: 77 % at 50 ms, all at 55 ms
  CHECK(std::abs(stream(2, 50'000, 286.4).with_one - 0.77) < 0.02);
  CHECK(stream(2, 55'000, 286.4).with_one == 1);
}

TEST_CASE("two identical packets with 0x55 in their payload are taken for another one, rotated") {
  // The measured example: the message 00 00 00 55 01 .. sent twice becomes LEDTOGGLE until the second packet is
  // complete.
  OhcDevice device;
  const Packet twice = packet(2, {0, 0, 0, 0x55, 1}, 3);
  const std::int64_t end = write(device, twice, started_us);
  CHECK(heard(device, end + 20'000).size() == 2);
  CHECK_FALSE(device.lamp());
  // the window that begins at byte 5 of the first is complete with byte 4 of the second
  for (std::size_t i = 0; i < 5; ++i) device.receive(twice[i], end + 50'000 + static_cast<std::int64_t>(i) * 260);
  heard(device, end + 70'000);
  CHECK(device.lamp());
  CHECK(device.counters()["ohc.packets.led_toggle"] == 1);
  CHECK(heard(device, end + 200'000).empty());
  for (std::size_t i = 5; i < twice.size(); ++i)
    device.receive(twice[i], end + 200'000 + static_cast<std::int64_t>(i) * 260);
  CHECK(heard(device, end + 300'000).size() >= 5);
  CHECK(device.counters()["ohc.packets.forward"] == 2);

  // with STOP between nothing of the kind happens
  OhcDevice other;
  std::int64_t at = started_us;
  for (int k = 0; k < 4; ++k) at = write(other, k % 2 ? packet(0, {}) : twice, at + 20'000);
  other.run_until(at + 100'000);
  CHECK(other.counters()["ohc.packets.led_toggle"] == 0);
  CHECK(other.counters()["ohc.packets.forward"] == 2);
}

TEST_CASE("a lost byte costs one packet and no more") {
  // There is no resynchronisation: the window simply slides on.
  OhcDevice device;
  const Packet run = packet(2, {}, 0x88), pause = packet(2, {}, 0x85);
  for (std::size_t i = 0; i < run.size(); ++i)
    if (i != 40) device.receive(run[i], started_us + static_cast<std::int64_t>(i) * 260);
  CHECK(heard(device, started_us + 100'000).empty());
  write(device, pause, started_us + 100'000);
  const auto sent = heard(device, started_us + 150'000);
  REQUIRE_FALSE(sent.empty());
  CHECK(sent[0].message.type == 0x85);
}

TEST_CASE("during its start-up the device acts on nothing and keeps the last packet only") {
  // 5 blinks of 0.4 s; the receiver is already on.
  OhcDevice device;
  write(device, packet(2, {}, 0x88), 100'000);
  write(device, packet(2, {}, 0x85), 300'000);
  CHECK(heard(device, started_us + 199).empty());
  const auto sent = heard(device, started_us + 5'000);
  REQUIRE(sent.size() == 1);
  CHECK(sent[0].start_us == started_us + 200);
  CHECK(sent[0].message.type == 0x85);
}

TEST_CASE("a flash page goes out as 22 messages while the line is deaf") {
  // Words little endian, three a message; the last carries two bytes of the page and the packet's checksum.
  OhcDevice device;
  std::array<std::uint8_t, 132> page{};
  page[0] = 0x55;
  page[1] = 4;
  page[2] = 7;
  for (std::size_t i = 0; i < 128; ++i) page[3 + i] = static_cast<std::uint8_t>(i);
  for (std::size_t i = 0; i + 1 < page.size(); ++i) page[131] ^= page[i];
  CHECK(page[131] == 0x56);  // the published example
  const std::int64_t end = write(device, page, started_us);
  const auto sent = heard(device, end + 300'000);
  REQUIRE(sent.size() == 22);
  CHECK(std::abs(sent.back().end_us - end - 98'000) < 300);
  for (std::size_t k = 0; k < sent.size(); ++k) {
    CHECK(sent[k].message.type == 0x81);
    CHECK(sent[k].message.data[0] == 7);
    CHECK(sent[k].message.data[1] == 3 * k);
    CHECK(sent[k].message.data[2] == 6 * k);
    CHECK(sent[k].message.data[8] == 0);
    CHECK(sent[k].message.crc == hal::kilobot::message_crc(sent[k].message));
    if (k > 0) CHECK(sent[k].start_us - sent[k - 1].start_us == 4443);
  }
  CHECK(sent.back().message.data[3] == 127);
  CHECK(sent.back().message.data[4] == 0x56);

  // packets 132 ms apart come through; at 125 ms the line is deaf to the beginning of some
  for (const auto& row : {std::pair{132'000, true}, {165'000, true}, {125'000, false}}) {
    const auto& [spacing_us, all] = row;
    CAPTURE(row.first);
    OhcDevice other;
    for (int k = 0; k < 40; ++k) {
      Packet numbered = page;
      numbered[2] ^= static_cast<std::uint8_t>(k);
      numbered[131] ^= static_cast<std::uint8_t>(k);
      write(other, numbered, started_us + k * spacing_us);
    }
    std::set<int> pages;
    for (const Transmission& message : heard(other, started_us + 41 * spacing_us))
      pages.insert(message.message.data[0]);
    CHECK((pages.size() == 40) == all);
    CHECK((other.counters()["ohc.bytes_lost.deaf"] == 0) == all);
  }
}

TEST_CASE("raw messages keep the host's checksum, positions go out until the first empty one") {
  // Types 3 and 5; type 1 only toggles the lamp, unknown types end a repetition.
  OhcDevice device;
  std::int64_t at = write(device, packet(3, {1, 2, 3, 4, 5, 6, 7, 8, 9, 0x7F, 0x34, 0x12}), started_us);
  auto sent = heard(device, at + 10'000);
  REQUIRE(sent.size() == 1);
  CHECK(sent[0].message.type == 0x7F);
  CHECK(sent[0].message.crc == 0x1234);

  at = write(device, packet(5, {1, 0, 10, 0, 20, 0, 30, 0, 2, 0, 11, 0, 21, 0, 31, 0}), at + 100'000);
  heard(device, at);
  sent = heard(device, at + 100'000);
  REQUIRE(sent.size() >= 2);
  std::erase_if(sent, [](const Transmission& one) { return one.message.type != 1; });
  REQUIRE(sent.size() == 2);
  CHECK(sent[1].message.data[0] == 2);
  CHECK(sent[1].message.data[6] == 31);
  CHECK(sent[1].start_us - sent[0].start_us == 4421);

  at = write(device, packet(2, {}, 5), at + 200'000);
  at = write(device, packet(99, {}), at + 100'000);
  heard(device, at + 11'000);
  CHECK(heard(device, at + 100'000).empty());
  CHECK(device.counters()["ohc.packets.unknown"] == 1);
}

TEST_CASE("an unplugged device forgets everything and starts anew") {
  // Its light goes out at once; bytes meanwhile are lost and counted.
  OhcDevice device;
  const std::int64_t end = write(device, packet(2, {}, 0x88), started_us);
  device.unplug(end + 52'000);
  CHECK(heard(device, end + 1'000'000).size() == 5);
  CHECK_FALSE(device.on_air(end + 52'000, end + 1'000'000));
  device.receive(0x55, end + 1'000'000);
  CHECK(device.counters()["ohc.bytes_lost.unplugged"] == 1);
  device.plug_in(end + 1'000'000);
  CHECK(heard(device, end + 5'000'000).empty());
  const std::int64_t again = write(device, packet(2, {}, 0x85), end + 5'000'000);
  CHECK(heard(device, again + 50'000).size() == 5);
}

TEST_CASE("what will be on the air is known as far as repetition goes") {
  // Robots sense the channel in spans that lie ahead: 42 % of the time it is busy.
  OhcDevice device;
  const std::int64_t end = write(device, packet(2, {}, 0x88), started_us), first = end + 200;
  device.run_until(first + 20'000);
  int busy = 0;
  for (int k = 0; k < 10'000; ++k) {
    const bool expected = k * 10 % 10'409 < 4371;
    CHECK(device.on_air(first + k * 10, first + k * 10 + 1) == expected);
    busy += expected;
  }
  CHECK(std::abs(busy - 4371) < 10);  // ten messages in the first 100 ms
  CHECK(device.on_air(first + 4371, first + 10'410));
  CHECK_FALSE(device.on_air(first + 4371, first + 10'409));
}
