#include "hal/arenas/inside_arena.hpp"

#include <algorithm>
#include <cmath>

namespace arkmesh::hal {

void keep_inside(PoseFrame& frame, const ArenaInfo& info, Counters& counters) {
  const double far_x_m = info.width_m / 2, far_y_m = info.height_m / 2;
  std::erase_if(frame.robots, [&](Observation& seen) {
    const char* refused = nullptr;
    if (!std::ranges::binary_search(info.robots, seen.robot))
      refused = "poses.refused.unknown_robot";
    else if (!(std::abs(seen.pose.x_m) <= far_x_m + info.body_radius_m &&
               std::abs(seen.pose.y_m) <= far_y_m + info.body_radius_m))
      refused = "poses.refused.outside";
    if (refused) counters.add(refused);
    seen.pose.x_m = std::clamp(seen.pose.x_m, -far_x_m, far_x_m);
    seen.pose.y_m = std::clamp(seen.pose.y_m, -far_y_m, far_y_m);
    return refused != nullptr;
  });
}

}  // namespace arkmesh::hal
