// The 12-byte infrared message of Kilobots, as robots and the overhead controller send it.
#pragma once

#include <array>
#include <cstdint>

namespace arkmesh::hal::kilobot {

struct Message {
  std::array<std::uint8_t, 9> data{};
  std::uint8_t type = 0;      // 0..127 for programs, above for the library
  std::uint16_t crc = 0;
  bool operator==(const Message&) const = default;
};
static_assert(sizeof(Message) == 12);

// Types above 127, kilolib message.h.
enum MessageType : std::uint8_t {
  type_boot = 0x80, type_boot_page, type_boot_size, type_reset, type_sleep, type_wakeup, type_charge, type_voltage, type_run,
  type_read_uid, type_calibrate
};

// CRC-16/MCRF4XX over data and type, byte by byte.
inline constexpr std::array<std::uint16_t, 256> crc_table = [] {
  std::array<std::uint16_t, 256> out{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0x8408 : crc >> 1;
    out[byte] = static_cast<std::uint16_t>(crc);
  }
  return out;
}();
constexpr std::uint16_t message_crc(const Message& message) {
  unsigned crc = 0xFFFF;
  const auto add = [&crc](std::uint8_t byte) { crc = crc >> 8 ^ crc_table[(crc ^ byte) & 0xFF]; };
  for (std::uint8_t byte : message.data) add(byte);
  add(message.type);
  return static_cast<std::uint16_t>(crc);
}
// the checksum of "123456789" and a zero byte is known
static_assert(message_crc({.data = {'1', '2', '3', '4', '5', '6', '7', '8', '9'}}) == (0x6F91 >> 8 ^ crc_table[0x91]));

}  // namespace arkmesh::hal::kilobot
