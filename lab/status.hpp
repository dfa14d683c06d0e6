// A lab's sign of life: channel `status`.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "arkmesh/lab_status_t.hpp"
#include "hal/counters.hpp"
#include "hal/types.hpp"

namespace arkmesh::lab {

struct Status {
  std::string lab;
  std::uint64_t run_id = 0;  // of the run
  std::string state;         // what the lab is doing, in words
  hal::LabTime stamp{0};
  std::uint32_t period = 0, last_period = 0;
  std::chrono::microseconds moving{0};  // how long its robots have moved, in the caller's time; 0 not yet
  bool can_wait = true;
  hal::Counters drops;   // everything dropped, replaced, late or refused
  hal::Counters counts;  // the scenario's totals; sent as "counts.NAME"
};

lab_status_t to_message(const Status& status);

}  // namespace arkmesh::lab
