// What people write on `arkmesh ohc`'s command line, as packets. Every function throws CLI::ValidationError for what
// cannot be meant.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/platforms/kilobot/packet.hpp"

namespace arkmesh::hal::kilobot {

// A number from 0 to `most`, decimal or 0x and hexadecimal; `what` is its name in the help.
std::uint16_t parse_number(const std::string& text, int most, const std::string& what);

// A message of a type that has no payload: run, reset, ...
hal::kilobot::Packet plain_packet(std::uint8_t type);

// The robots' calibration message: what it is to set; its id; its duties, turning left and right, and both going
// straight.
enum class Calibrate : std::uint8_t { save = 0, id = 1, left = 2, right = 3, straight = 4 };
hal::kilobot::Packet calibrate_packet(Calibrate what, std::uint16_t id = 0, std::array<std::uint8_t, 4> duties = {});

// A type from 0 to 127, then up to nine bytes.
hal::kilobot::Packet message_packet(const std::vector<std::string>& numbers);

}  // namespace arkmesh::hal::kilobot
