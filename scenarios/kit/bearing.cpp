#include "scenarios/kit/bearing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "hal/fixed_math.hpp"

namespace arkmesh::scenarios::kit {
namespace {

constexpr double circle = 2 * std::numbers::pi;

double steps(double low, double high, int bits) {
  if (bits < 1 || bits > 24 || !(low < high) || !std::isfinite(low) || !std::isfinite(high))
    throw std::invalid_argument("a number needs 1 to 24 bits and two bounds");
  return static_cast<double>(1U << bits);
}

}  // namespace

double bearing_rad(const hal::Pose& robot, const hal::Point& place) {
  const double x = place.x_m - robot.x_m, y = place.y_m - robot.y_m;
  if (x == 0 && y == 0) return 0;
  const double bearing = std::remainder(hal::fixed::atan2(y, x) - robot.heading_rad, circle);
  return bearing <= -std::numbers::pi ? std::numbers::pi : bearing;
}

double distance_m(const hal::Pose& robot, const hal::Point& place) {
  return hal::fixed::hypot(place.x_m - robot.x_m, place.y_m - robot.y_m);
}

std::uint32_t quantized(double value, double low, double high, int bits) {
  const double all = steps(low, high, bits), step = std::floor((value - low) / (high - low) * all);
  if (!(step > 0)) return 0;  // also not-a-number
  return static_cast<std::uint32_t>(std::min(step, all - 1));
}

}  // namespace arkmesh::scenarios::kit
