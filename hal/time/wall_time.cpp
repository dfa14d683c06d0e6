// Sleeps to absolute moments, so that no error adds up.
#include "hal/time/wall_time.hpp"

#include <cerrno>
#include <ctime>

namespace arkmesh::hal {
namespace {

class MachineTime final : public WallTime {
 public:
  TimePoint now() override { return TimePoint::clock::now(); }
  void wait_until(TimePoint then) override {
    if (then <= now()) return;
    // steady_clock is CLOCK_MONOTONIC here
    const auto since_boot = std::chrono::duration_cast<std::chrono::nanoseconds>(then.time_since_epoch());
    timespec until{};
    until.tv_sec = static_cast<std::time_t>(since_boot.count() / 1'000'000'000);
    until.tv_nsec = static_cast<long>(since_boot.count() % 1'000'000'000);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
  }
};

}  // namespace

WallTime& machine_time() {
  static MachineTime time;
  return time;
}

}  // namespace arkmesh::hal
