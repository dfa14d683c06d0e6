// The Thymio II, real or simulated.
#pragma once

#include "hal/robot/robot_kind.hpp"

namespace arkmesh::hal {

RobotKind thymio();

// A wheel's set point in the robot's own unit, for a speed in mm/s: about 500 at 200 mm/s, its greatest.
inline constexpr double thymio_target_per_mm_s = 2.5;

}  // namespace arkmesh::hal
