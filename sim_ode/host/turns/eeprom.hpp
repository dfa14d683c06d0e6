// Where a robot's library keeps its values in the EEPROM, as programs with avr/eeprom.h see it: 1 KB, inverted, so that
// zero is an erased byte.
#pragma once

#include <cstdint>
#include <span>

#include "sim_ode/host/turns/firmware.hpp"

namespace arkmesh::sim_ode {

inline constexpr std::size_t eeprom_uid = 0xB0, eeprom_turn_left = 0x05, eeprom_turn_right = 0x09,
                             eeprom_straight_left = 0x0C, eeprom_straight_right = 0x14, eeprom_low_gain = 0x20,
                             eeprom_high_gain = 0x50;

inline void store_values(std::uint8_t* eeprom, const RobotValues& values) {
  const auto write = [eeprom](std::size_t at, unsigned byte) { eeprom[at] = static_cast<std::uint8_t>(~byte); };
  write(eeprom_uid, values.uid);
  write(eeprom_uid + 1, values.uid >> 8);
  write(eeprom_turn_left, values.duties.turn_left);
  write(eeprom_turn_right, values.duties.turn_right);
  write(eeprom_straight_left, values.duties.straight_left);
  write(eeprom_straight_right, values.duties.straight_right);
}

inline RobotValues stored_values(const std::uint8_t* eeprom) {
  const auto read = [eeprom](std::size_t at) { return static_cast<std::uint8_t>(~eeprom[at]); };
  return {.uid = static_cast<std::uint16_t>(read(eeprom_uid) | read(eeprom_uid + 1) << 8),
          .duties = {read(eeprom_turn_left), read(eeprom_turn_right), read(eeprom_straight_left),
                     read(eeprom_straight_right)}};
}

// A table of distance readings, big endian.
inline void store_table(std::uint8_t* eeprom, std::size_t at, std::span<const std::uint16_t> table) {
  for (const std::uint16_t value : table) {
    eeprom[at++] = static_cast<std::uint8_t>(~(value >> 8));
    eeprom[at++] = static_cast<std::uint8_t>(~value);
  }
}

}  // namespace arkmesh::sim_ode
