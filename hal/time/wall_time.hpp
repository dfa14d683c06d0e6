// The time that emulators and devices live by. Usually the machine's monotonic clock; an emulated testbed that is
// computed faster than life brings its own, so that the same code runs in it. None of it reaches a result of an arena
// that can wait.
#pragma once

#include <chrono>

namespace arkmesh::hal {

// A point of monotonic time.
using TimePoint = std::chrono::steady_clock::time_point;

class WallTime {
 public:
  virtual ~WallTime() = default;
  virtual TimePoint now() = 0;
  // Returns at `then`, or at once when that is past. For whoever runs an arena: arenas themselves never wait.
  virtual void wait_until(TimePoint then) = 0;
};

// The machine's own. Lives as long as the process.
WallTime& machine_time();

}  // namespace arkmesh::hal
