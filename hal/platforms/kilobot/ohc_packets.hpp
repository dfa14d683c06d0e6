// What people write when they drive an overhead controller by hand, as packets. Every function throws WrongWord for
// what cannot be meant.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hal/platforms/kilobot/packet.hpp"

namespace arkmesh::hal::kilobot {

// One sentence about what was written, and the name that it has in the help.
class WrongWord : public std::runtime_error {
 public:
  WrongWord(std::string name, const std::string& sentence) : std::runtime_error(sentence), name_(std::move(name)) {}
  const std::string& name() const { return name_; }

 private:
  std::string name_;
};

// A number from 0 to `most`, decimal or 0x and hexadecimal; `name` is its name in the help.
std::uint16_t parse_number(const std::string& text, int most, const std::string& name);

// A message of a type that has no payload: run, reset, ...
Packet plain_packet(std::uint8_t type);

// Gives all robots in sight an id, and saves it.
std::vector<Packet> set_id_packets(std::uint16_t id);
// The duties at which robots turn left, turn right, and go straight, each 0 to 255.
Packet turn_left_packet(const std::string& duty);
Packet turn_right_packet(const std::string& duty);
Packet straight_packet(const std::string& left, const std::string& right);
// Robots keep the duties and the id that they were given.
Packet save_packet();

// A type from 0 to 127, then up to nine bytes.
Packet message_packet(const std::vector<std::string>& numbers);

}  // namespace arkmesh::hal::kilobot
