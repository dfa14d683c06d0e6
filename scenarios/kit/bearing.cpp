#include "scenarios/kit/bearing.hpp"

#include <cmath>
#include <numbers>

#include "hal/fixed_math.hpp"

namespace arkmesh::scenarios::kit {
namespace {

constexpr double circle = 2 * std::numbers::pi;

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

}  // namespace arkmesh::scenarios::kit
