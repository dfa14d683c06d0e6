// Sleeps to absolute moments, so that no error adds up.
#include "hal/pacer.hpp"

#include <cerrno>
#include <ctime>

namespace arkmesh::hal {

void Pacer::wait_until(LabTime t) {
  if (t <= LabTime{0}) return;
  if (!start_) start_ = Monotonic::now();
  const Monotonic::time_point end = *start_ + t;
  if (Monotonic::now() > end + frame_period_) counters_.add("arena.late");

  // steady_clock is CLOCK_MONOTONIC here
  const auto since_boot = std::chrono::duration_cast<std::chrono::nanoseconds>(end.time_since_epoch());
  timespec until{};
  until.tv_sec = static_cast<std::time_t>(since_boot.count() / 1'000'000'000);
  until.tv_nsec = static_cast<long>(since_boot.count() % 1'000'000'000);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace arkmesh::hal
