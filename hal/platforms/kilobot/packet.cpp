// Offsets: 0 header, 1 type, 2.. payload, 131 checksum; bytes not used are zero.
#include "hal/platforms/kilobot/packet.hpp"

#include <algorithm>

namespace arkmesh::hal::kilobot {
namespace {

constexpr std::size_t payload_at = 2, checksum_at = packet_bytes - 1;

Packet begin(PacketType type) {
  Packet packet{};
  packet[0] = packet_header;
  packet[1] = static_cast<std::uint8_t>(type);
  return packet;
}

Packet finish(Packet packet) {
  packet[checksum_at] = packet_checksum(packet);
  return packet;
}

Packet with_message(PacketType type, const Message& message) {
  Packet packet = begin(type);
  std::ranges::copy(message.data, packet.begin() + payload_at);
  packet[payload_at + message.data.size()] = message.type;
  return packet;
}

}  // namespace

std::uint8_t packet_checksum(const Packet& packet) {
  std::uint8_t sum = 0;
  for (std::size_t i = 0; i < checksum_at; ++i) sum ^= packet[i];
  return sum;
}

bool is_packet(std::span<const std::uint8_t, packet_bytes> bytes) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : bytes) sum ^= byte;
  return bytes[0] == packet_header && sum == 0;
}

Packet stop_packet(std::uint8_t filler) {
  Packet packet = begin(PacketType::stop);
  packet[payload_at] = filler;
  return finish(packet);
}

Packet led_toggle_packet() {
  return finish(begin(PacketType::led_toggle));
}

Packet forward_packet(const Message& message) {
  return finish(with_message(PacketType::forward, message));
}

Packet forward_once_packet(const Message& message) {
  return finish(with_message(PacketType::forward_once, message));
}

Packet forward_raw_packet(const Message& message) {
  Packet packet = with_message(PacketType::forward_raw, message);
  packet[12] = static_cast<std::uint8_t>(message.crc);
  packet[13] = static_cast<std::uint8_t>(message.crc >> 8);
  return finish(packet);
}

Packet boot_page_packet(std::uint8_t page, std::span<const std::uint8_t, page_bytes> bytes) {
  Packet packet = begin(PacketType::boot_page);
  packet[payload_at] = page;
  std::ranges::copy(bytes, packet.begin() + payload_at + 1);
  return finish(packet);
}

std::optional<std::size_t> false_packet_between(const Packet& first, const Packet& second) {
  // The window that begins at offset i holds the end of `first` and i bytes of `second`. Both sum to zero as a whole,
  // so the window does when both beginnings have the same sum.
  std::uint8_t difference = 0;
  for (std::size_t i = 1; i < packet_bytes; ++i) {
    difference ^= first[i - 1] ^ second[i - 1];
    if (first[i] == packet_header && difference == 0) return i;
  }
  return {};
}

Packet parting_stop(const Packet& first, const Packet& second) {
  // Behind offset 2 each filler gives another sum, and `first` has at most 131 headers to meet it: one of 256 is free.
  for (int filler = 0; filler < 256; ++filler) {
    const Packet stop = stop_packet(static_cast<std::uint8_t>(filler));
    if (!false_packet_between(first, stop) && !false_packet_between(stop, second)) return stop;
  }
  return stop_packet();
}

}  // namespace arkmesh::hal::kilobot
