// What a simulated robot's receiver hands to its program.
#pragma once

#include <cstdint>

#include "hal/platforms/kilobot/body.hpp"
#include "hal/platforms/kilobot/message.hpp"

namespace arkmesh::sim_ode {

// The simulated robots speak the real ones' messages.
using hal::kilobot::Message;
using hal::kilobot::message_crc;
using enum hal::kilobot::MessageType;

// A message that a robot receives, with the readings of its strength.
struct Reception {
  int robot = 0;
  std::uint32_t at_us = 0;  // its end, after the start of the tick it was sent in
  std::int16_t low_gain = 0, high_gain = 0;
  Message message;
};

using hal::kilobot::tick_us;

}  // namespace arkmesh::sim_ode
