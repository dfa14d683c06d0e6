// Where a place lies as a robot would measure it. Pure arithmetic.
#pragma once

#include <cstdint>

#include "hal/types.hpp"

namespace arkmesh::scenarios::kit {

// From the robot's heading, counter-clockwise, -pi < bearing <= pi. 0 for the place where it is.
double bearing_rad(const hal::Pose& robot, const hal::Point& place);
double distance_m(const hal::Pose& robot, const hal::Point& place);
// The square of the distance of two places or poses.
constexpr double distance2_m2(const auto& one, const auto& other) {
  const double x_m = one.x_m - other.x_m, y_m = one.y_m - other.y_m;
  return x_m * x_m + y_m * y_m;
}

}  // namespace arkmesh::scenarios::kit
