// Where there is room on an arena of robots: for a walk, for a turn. Knows places only, not who does what.
#pragma once

#include <utility>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::tracker {

// Where robots are now.
using Places = std::vector<std::pair<hal::RobotId, hal::Pose>>;

class OpenGround {
 public:
  // `body_m`: radius of a robot's body. `turn_m`: from where a robot stands to the middle of itself on the far side of
  // its turning circle.
  OpenGround(double width_m, double height_m, double body_m, double turn_m)
      : width_m_(width_m), height_m_(height_m), body_m_(body_m), turn_m_(turn_m) {}

  static constexpr double enough_m = 0.22;  // room that a straight way should have

  // How far the robot gets in that direction before it meets a wall or another one where they are now; not farther than
  // enough_m.
  double free_way_m(hal::RobotId robot, const hal::Pose& pose, double course_rad, const Places& places) const;
  // The freest way, the first to the left of straight ahead if several are free enough.
  struct Way {
    double course_rad = 0, free_m = 0;
  };
  Way freest_way(hal::RobotId robot, const hal::Pose& pose, const Places& places) const;
  // It is at a wall or at another robot.
  bool touches(hal::RobotId robot, const hal::Pose& pose, const Places& places) const;
  // Somebody or a wall is nearer than a turn needs.
  bool crowded(hal::RobotId robot, const hal::Pose& pose, const Places& places) const;

 private:
  bool walled(const hal::Pose& pose, double near_m) const;
  static bool met(hal::RobotId robot, const hal::Pose& pose, const Places& places, double near_m);

  double width_m_, height_m_, body_m_, turn_m_;
};

}  // namespace arkmesh::tracker
