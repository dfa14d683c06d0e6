// Read-only lab time. Only Arena::advance_to moves it.
#pragma once

#include "hal/types.hpp"

namespace arkmesh::hal {

class Clock {
 public:
  LabTime now() const { return now_; }

 protected:
  ~Clock() = default;
  LabTime now_{0};
};

// The clock as its owner (an arena) holds it.
class OwnedClock final : public Clock {
 public:
  void set(LabTime now) { now_ = now; }
};

}  // namespace arkmesh::hal
