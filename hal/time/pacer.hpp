// Keeps lab time in step with the wall, for arenas that cannot wait: says when moments are and whether they have come.
// Never waits. Counts as `late` each lab time that was reached more than one frame period after its moment.
#pragma once

#include <optional>

#include "hal/counters.hpp"
#include "hal/time/wall_time.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

class Pacer {
 public:
  // `counters` and `wall` outlive the pacer.
  Pacer(LabTime frame_period, Counters& counters, WallTime& wall = machine_time())
      : frame_period_(frame_period), counters_(counters), wall_(wall) {}
  // Whether lab time t has come. The first call with t > 0, of this or of moment_of, sets when lab time 0 was: now.
  bool reached(LabTime t);
  // When lab time t is, for arenas that have something to do until then. t > 0.
  TimePoint moment_of(LabTime t);
  // When the lab time is that reached() has denied; TimePoint::max() when it has denied none since it last agreed.
  TimePoint next() const { return next_; }

 private:
  LabTime frame_period_;
  Counters& counters_;
  WallTime& wall_;
  std::optional<TimePoint> start_;
  TimePoint next_ = TimePoint::max();
};

}  // namespace arkmesh::hal
