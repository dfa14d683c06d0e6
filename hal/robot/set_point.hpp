// Speeds of a robot's two wheels as a word to it, in a register of its own, so that a recording and whoever carries
// words need no other kind of message.
#pragma once

#include <optional>

#include "hal/robot/robot_kind.hpp"

namespace arkmesh::hal {

struct SetPoint {
  int left_mm_s = 0, right_mm_s = 0;  // of the ground under each wheel; negative: backwards
  bool operator==(const SetPoint&) const = default;
};

// The register of set points, of robots that can be driven. In others it is one like any other.
inline constexpr std::uint8_t set_point_slot = 255;

// In force until the next one, or until the robot's own program moves the wheels; while robots pause they stand. Speeds
// beyond
// +-2047 mm/s are cut.
ToRobot to_robot(RobotId robot, const SetPoint& wheels);
// Nothing: a word of the scenario, or no robot that can be driven. Speeds are those it can reach.
std::optional<SetPoint> set_point_in(const RobotKind& robot, const ToRobot& word);

}  // namespace arkmesh::hal
