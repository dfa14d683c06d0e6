// How cameras follow Kilobots: the tracker's settings with this robot's measures in them.
#pragma once

#include "hal/platforms/kilobot/body.hpp"
#include "tracker/follow/arena_tracker.hpp"

namespace arkmesh::testbed {

inline constexpr double led_offset_deg = -hal::kilobot::led_bearing_deg;  // driving direction minus LED direction

inline tracker::Body kilobot_body(double board_m = hal::kilobot::board_height_m) {
  return {.diameter_m = 2 * hal::kilobot::body_radius_m,
          .board_m = board_m,
          .led_m = board_m + hal::kilobot::led_above_board_m};
}

inline tracker::AssociatorSettings kilobot_following() {
  tracker::AssociatorSettings out;
  out.diameter_m = 2 * hal::kilobot::body_radius_m;
  out.led_offset_rad = -hal::kilobot::led_bearing_rad;
  out.led_offset_error_rad = hal::kilobot::led_bearing_spread_rad;
  out.motion.rear_axle_m = hal::kilobot::rear_axle_m;
  return out;
}

inline tracker::ArenaTrackerSettings kilobot_tracking() {
  tracker::ArenaTrackerSettings out;
  out.body = kilobot_body();
  out.following = kilobot_following();
  return out;
}

}  // namespace arkmesh::testbed
