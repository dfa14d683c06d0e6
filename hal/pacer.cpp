#include "hal/pacer.hpp"

namespace arkmesh::hal {

WallTime::Moment Pacer::moment_of(LabTime t) {
  if (!start_) start_ = wall_.now();
  return *start_ + t;
}

void Pacer::wait_until(LabTime t) {
  if (t <= LabTime{0}) return;
  const WallTime::Moment end = moment_of(t);
  if (wall_.now() > end + frame_period_) counters_.add("arena.late");
  wall_.wait_until(end);
}

}  // namespace arkmesh::hal
