// The 12-byte infrared message of Kilobots, as robots and the overhead controller send it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace arkmesh::hal::kilobot {

struct Message {
  std::array<std::uint8_t, 9> data{};
  std::uint8_t type = 0;  // 0..127 for programs, above for the library
  std::uint16_t crc = 0;
  bool operator==(const Message&) const = default;
};
static_assert(sizeof(Message) == 12);

// Types above 127, kilolib message.h.
enum MessageType : std::uint8_t {
  type_boot = 0x80,
  type_boot_page,
  type_boot_size,
  type_reset,
  type_sleep,
  type_wakeup,
  type_charge,
  type_voltage,
  type_run,
  type_read_uid,
  type_calibrate
};

// CRC-16/MCRF4XX over data and type. What each byte contributes depends on its place only, so a message is ten look-ups
// that do not wait for each other.
inline constexpr std::array<std::array<std::uint16_t, 256>, 10> crc_tables = [] {
  std::array<std::array<std::uint16_t, 256>, 10> out{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0x8408 : crc >> 1;
    out[9][byte] = static_cast<std::uint16_t>(crc);
  }
  for (std::size_t at = 9; at-- > 0;)
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const unsigned later = out[at + 1][byte];
      out[at][byte] = static_cast<std::uint16_t>(later >> 8 ^ out[9][later & 0xFF]);
    }
  return out;
}();
constexpr std::uint16_t message_crc(const Message& message) {
  // the start value 0xFFFF goes into the first two bytes
  unsigned crc =
      crc_tables[0][message.data[0] ^ 0xFFu] ^ crc_tables[1][message.data[1] ^ 0xFFu] ^ crc_tables[9][message.type];
  for (std::size_t at = 2; at < 9; ++at) crc ^= crc_tables[at][message.data[at]];
  return static_cast<std::uint16_t>(crc);
}
// the checksum of "123456789" and a zero byte is known
static_assert(message_crc({.data = {'1', '2', '3', '4', '5', '6', '7', '8', '9'}}) ==
              (0x6F91 >> 8 ^ crc_tables[9][0x91]));

constexpr Message with_crc(Message message) {
  message.crc = message_crc(message);
  return message;
}

}  // namespace arkmesh::hal::kilobot
