#include "hal/pacer.hpp"

namespace arkmesh::hal {

void Pacer::wait_until(LabTime t) {
  if (t <= LabTime{0}) return;
  if (!start_) start_ = wall_.now();
  const WallTime::Moment end = *start_ + t;
  if (wall_.now() > end + frame_period_) counters_.add("arena.late");
  wall_.wait_until(end);
}

}  // namespace arkmesh::hal
