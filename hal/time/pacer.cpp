#include "hal/time/pacer.hpp"

namespace arkmesh::hal {

TimePoint Pacer::moment_of(LabTime t) {
  if (!start_) start_ = wall_.now();
  return *start_ + t;
}

bool Pacer::reached(LabTime t) {
  if (t <= LabTime{0}) return true;
  const TimePoint moment = moment_of(t), now = wall_.now();
  next_ = now < moment ? moment : TimePoint::max();
  if (now < moment) return false;
  if (now > moment + frame_period_) counters_.add("late");
  return true;
}

}  // namespace arkmesh::hal
