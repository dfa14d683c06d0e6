// One lab's part of the shared world, as it is merged at a boundary.
#pragma once

#include <cstdint>
#include <string>

#include "lab/exchange/lab_state.hpp"

namespace arkmesh::lab {

struct MergedState {
  std::string lab;
  KeptState state;               // in force from now on
  std::int64_t age_periods = 0;  // how old it is at this boundary
  KeptState initial;             // its run's state 0, when this is the first of that run that is merged; else null
  std::int64_t payload_age_periods = 0;  // how old its robots and fields are, which may be older, or an early event's
};

}  // namespace arkmesh::lab
