#include "tracker/identity/open_ground.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace arkmesh::tracker {

double OpenGround::free_way_m(hal::RobotId robot, const hal::Pose& pose, double course_rad,
                              const Places& places) const {
  const double dx = std::cos(course_rad), dy = std::sin(course_rad), margin_m = body_m_ + 0.006;
  double free_m = enough_m;
  const auto wall = [&free_m](double place_m, double towards, double limit_m) {
    if (towards > 1e-9) free_m = std::min(free_m, std::max(0.0, (limit_m - place_m) / towards));
  };
  wall(pose.x_m, dx, width_m_ / 2 - margin_m);
  wall(-pose.x_m, -dx, width_m_ / 2 - margin_m);
  wall(pose.y_m, dy, height_m_ / 2 - margin_m);
  wall(-pose.y_m, -dy, height_m_ / 2 - margin_m);
  const double clear_m = 2 * body_m_ + 0.015;
  for (const auto& [other, place] : places) {
    if (other == robot) continue;
    const double ahead_m = (place.x_m - pose.x_m) * dx + (place.y_m - pose.y_m) * dy;
    const double beside_m = std::abs((place.y_m - pose.y_m) * dx - (place.x_m - pose.x_m) * dy);
    if (ahead_m > 0 && beside_m < clear_m)
      free_m = std::min(free_m, std::max(0.0, ahead_m - std::sqrt(clear_m * clear_m - beside_m * beside_m)));
  }
  return free_m;
}

OpenGround::Way OpenGround::freest_way(hal::RobotId robot, const hal::Pose& pose, const Places& places) const {
  constexpr int courses = 36;
  Way best{.course_rad = pose.heading_rad, .free_m = -1};
  for (int k = 0; k < courses && best.free_m < enough_m; ++k) {
    const double course_rad = pose.heading_rad + k * 2 * std::numbers::pi / courses;
    const double free_m = free_way_m(robot, pose, course_rad, places);
    if (free_m > best.free_m + 1e-9) best = {course_rad, free_m};
  }
  return best;
}

bool OpenGround::touches(hal::RobotId robot, const hal::Pose& pose, const Places& places) const {
  const double near_m = body_m_ + 0.0015;
  return walled(pose, near_m) || met(robot, pose, places, 2 * near_m);
}

bool OpenGround::crowded(hal::RobotId robot, const hal::Pose& pose, const Places& places) const {
  const double far_side_m = turn_m_ + body_m_;
  return walled(pose, far_side_m) || met(robot, pose, places, far_side_m + body_m_);
}

bool OpenGround::walled(const hal::Pose& pose, double near_m) const {
  return std::abs(pose.x_m) > width_m_ / 2 - near_m || std::abs(pose.y_m) > height_m_ / 2 - near_m;
}

bool OpenGround::met(hal::RobotId robot, const hal::Pose& pose, const Places& places, double near_m) {
  return std::any_of(places.begin(), places.end(), [&](const auto& other) {
    return other.first != robot && std::hypot(other.second.x_m - pose.x_m, other.second.y_m - pose.y_m) < near_m;
  });
}

}  // namespace arkmesh::tracker
