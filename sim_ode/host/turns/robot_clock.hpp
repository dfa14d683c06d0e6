// A robot's own clock against the ticks of lab time.
#pragma once

#include <cstdint>

#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {

struct RobotClock {
  std::int64_t at_us = 0;    // its timer comes so long after the start of the present tick
  std::int64_t late_us = 0;  // that each tick of it takes longer than it should

  // How often the timer comes in the next tick. A slow timer's moment comes later in each tick, until one has none; a
  // fast one's earlier, until one has two.
  unsigned next_tick() {
    at_us += late_us;
    if (at_us >= tick_us) {
      at_us -= tick_us;
      return 0;
    }
    if (at_us < 0) {
      at_us += tick_us;
      return 2;
    }
    return 1;
  }
};

}  // namespace arkmesh::sim_ode
