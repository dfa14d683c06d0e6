// Where a place lies as a robot would measure it, and positions as so many bits. Pure arithmetic.
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

// `value` within low..high as a whole number of so many bits (1 to 24): 0 at low, the largest at high; beyond them the
// nearest. Throws std::invalid_argument for bits or bounds that make no sense.
std::uint32_t quantized(double value, double low, double high, int bits);

}  // namespace arkmesh::scenarios::kit
