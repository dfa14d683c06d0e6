// What robots hear at the start of a tick.
#pragma once

#include <cstdint>
#include <vector>

#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {

struct Inbox {
  struct Overhead {
    std::uint32_t at_us = 0;  // as Reception::at_us
    Message message;
    std::vector<std::uint8_t> missed;  // by robot; empty: nobody missed it
    bool reaches(int robot) const { return missed.empty() || !missed[static_cast<std::size_t>(robot)]; }
  };
  std::vector<Overhead> overhead;   // ascending at_us; everybody's
  std::vector<Reception> infrared;  // ascending by robot, then at_us
};

}  // namespace arkmesh::sim_ode
