// Keeps lab time in step with the wall: for arenas that cannot wait. Counts as `arena.late` each time it is asked to
// wait for a moment that passed more than one frame period ago.
#pragma once

#include <optional>

#include "hal/counters.hpp"
#include "hal/types.hpp"
#include "hal/wall_time.hpp"

namespace arkmesh::hal {

class Pacer {
 public:
  // `counters` and `wall` outlive the pacer.
  Pacer(LabTime frame_period, Counters& counters, WallTime& wall = machine_time())
      : frame_period_(frame_period), counters_(counters), wall_(wall) {}
  // Blocks until lab time t. The first call with t > 0, of this or of moment_of, sets when lab time 0 was: now.
  void wait_until(LabTime t);
  // When lab time t is, for arenas that have something to do until then. t > 0.
  WallTime::Moment moment_of(LabTime t);

 private:
  LabTime frame_period_;
  Counters& counters_;
  WallTime& wall_;
  std::optional<WallTime::Moment> start_;
};

}  // namespace arkmesh::hal
