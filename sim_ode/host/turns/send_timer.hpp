// What passes between robots' send timers and the infrared medium: the host offers, the medium finds out how the
// channel is at that moment, the robot acts on it in a turn of its own.
#pragma once

#include <cstdint>
#include <optional>

#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {

// A robot would send when its timer comes.
struct Offer {
  int robot;
  std::int64_t at_us;  // after the start of the present tick
};

// What its moment brings. A robot that receives a message then gets none: it is not interrupted.
struct Outcome {
  int robot;
  bool free;  // what it sends goes out undisturbed; otherwise it senses somebody else's light and backs off
};

// What the robot does about it.
struct Reply {
  std::optional<Message> message;  // nothing: it has nothing to send
  std::uint32_t back_off_us = 0;   // of one that was not free: until it tries again
};

}  // namespace arkmesh::sim_ode
