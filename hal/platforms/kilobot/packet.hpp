// The 132-byte packets that a computer sends to an overhead controller (OHC) over its serial line. Bytes only: when to
// send which is PacketSender's business. Layout and behaviour as in the controller's firmware (kilolib ohc.c).
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/platforms/kilobot/message.hpp"

namespace arkmesh::hal::kilobot {

inline constexpr std::size_t packet_bytes = 132;
inline constexpr std::size_t page_bytes = 128;  // of the robots' flash, in one boot_page packet
inline constexpr std::uint8_t packet_header = 0x55;
inline constexpr int line_baud = 38400;  // 8 data bits, no parity, 1 stop bit: ten bits a byte
// How long a packet is on the serial line; infrared bits that the controller emits meanwhile are distorted.
inline constexpr std::chrono::microseconds packet_on_line{packet_bytes * 10 * 1'000'000 / line_baud};
// Start to start, the smallest that gets a clean copy through with a margin when the controller repeats (boot pages
// excepted): 50 ms leave 2 ms, gone with bytes 10 % further apart; 60 ms give two copies.
inline constexpr std::chrono::microseconds usual_spacing{55'000};

// A stop only has to be understood; bytes may lie apart a little.
inline constexpr std::chrono::microseconds stop_spacing{40'000};

enum class PacketType : std::uint8_t {
  stop,          // ends a repetition
  led_toggle,    // the controller's own lamp; ends a repetition too
  forward,       // the controller computes the checksum of the message and repeats it until the next packet
  forward_raw,   // the same with the checksum that the computer gives
  boot_page,     // one page of flash, once; the controller is deaf for 98 ms
  gps_frame,     // up to 16 messages of type 1, once
  forward_once,  // as forward, sent once
};

using Packet = std::array<std::uint8_t, packet_bytes>;

// `filler` goes into a byte that the controller ignores: it makes a stop that differs from another.
Packet stop_packet(std::uint8_t filler = 0);
Packet led_toggle_packet();
Packet forward_packet(const Message& message);
Packet forward_once_packet(const Message& message);
// With the message's own checksum, whatever it is.
Packet forward_raw_packet(const Message& message);
Packet boot_page_packet(std::uint8_t page, std::span<const std::uint8_t, page_bytes> bytes);

// The byte that makes the exclusive or of all 132 bytes zero.
std::uint8_t packet_checksum(const Packet& packet);
bool is_packet(std::span<const std::uint8_t, packet_bytes> bytes);

// The controller takes any 132 bytes that begin with the header and have a right checksum, so the end of one packet and
// the beginning of the next can look like a packet between them. Gives the first offset in `first` where that
// happens, 1..131; nothing when `second` may follow directly.
std::optional<std::size_t> false_packet_between(const Packet& first, const Packet& second);

// A stop packet that may follow `first` and be followed by `second`, whatever they hold.
Packet parting_stop(const Packet& first, const Packet& second);

}  // namespace arkmesh::hal::kilobot
