// Keeps lab time in step with the wall: for arenas that cannot wait. Counts as `arena.late` each time it is asked to
// wait for a moment that passed more than one frame period ago.
#pragma once

#include <chrono>
#include <optional>

#include "hal/counters.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

class Pacer {
 public:
  // `counters` outlives the pacer.
  Pacer(LabTime frame_period, Counters& counters) : frame_period_(frame_period), counters_(counters) {}
  // Blocks until lab time t. The first call with t > 0 sets when lab time 0 was: now.
  void wait_until(LabTime t);

 private:
  using Monotonic = std::chrono::steady_clock;
  LabTime frame_period_;
  Counters& counters_;
  std::optional<Monotonic::time_point> start_;
};

}  // namespace arkmesh::hal
