// How a lab sees the shared world: shared = shift + scale * turn(arena). The same speed over a smaller arena is a
// faster robot.
#pragma once

#include "hal/config/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

struct Projection {
  double shift_x_m = 0;  // place of the arena's centre in the shared frame
  double shift_y_m = 0;
  double turn_rad = 0;  // counter-clockwise, from arena +x to shared +x
  double scale = 1;     // shared metres per arena metre, > 0

  void fields(const Section& s) {
    s.field("shift_x_m", shift_x_m, {{-1000, 1000}, "m", "position of the arena's centre in the shared frame"});
    s.field("shift_y_m", shift_y_m, {{-1000, 1000}, "m", "position of the arena's centre in the shared frame"});
    s.field("turn_rad", turn_rad,
            {{-7, 7}, "rad", "rotation from the arena's frame to the shared frame, counter-clockwise"});
    s.field("scale", scale, {{1e-3, 1e3}, "", "shared metres per metre of the arena"});
  }

  Pose to_shared(const Pose& in_arena) const;
  Pose to_arena(const Pose& in_shared) const;
};

}  // namespace arkmesh::hal
