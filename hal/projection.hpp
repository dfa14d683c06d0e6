// How a lab sees the shared world: shared = shift + scale * turn(arena). The same speed over a smaller arena is a
// faster robot.
#pragma once

#include "hal/types.hpp"

namespace arkmesh::hal {

struct Projection {
  double shift_x_m = 0;  // place of the arena's centre in the shared frame
  double shift_y_m = 0;
  double turn_rad = 0;  // counter-clockwise, from arena +x to shared +x
  double scale = 1;     // shared metres per arena metre, > 0

  Pose to_shared(const Pose& in_arena) const;
  Pose to_arena(const Pose& in_shared) const;
};

}  // namespace arkmesh::hal
