#include "scenarios/cre/robot_messages.hpp"

#include <bit>
#include <cmath>
#include <numbers>

#include "scenarios/cre/controller/cre_messages.h"
#include "scenarios/kit/bearing.hpp"

namespace arkmesh::scenarios::cre {
namespace {

// Five bits of a reading.
int density_bits(int active, int places) {
  return places == 0 ? CRE_NO_PLACE
                     : static_cast<int>(std::lround(static_cast<double>(static_cast<int>(CRE_FULL) * active) / places));
}

std::uint16_t compass(double heading_rad) {
  const auto steps = std::lround(heading_rad / (2 * std::numbers::pi) * static_cast<int>(CRE_TURN));
  return static_cast<std::uint16_t>(((steps % CRE_TURN) + CRE_TURN) % CRE_TURN);
}

}  // namespace

std::optional<Region> opinion_of(hal::Led led) {
  if (led == for_north) return Region::north;
  if (led == for_south) return Region::south;
  return std::nullopt;
}

std::uint8_t wall_of(std::uint8_t sectors) {
  if (std::popcount(sectors) <= 2) return CRE_NO_WALL;
  const int left = std::popcount(static_cast<unsigned>(sectors >> 4)), right = std::popcount(sectors & 15u);
  return left > right ? CRE_WALL_LEFT : right > left ? CRE_WALL_RIGHT : CRE_WALL_AHEAD;
}

hal::ToRobot reading(hal::RobotId robot, const Sight& sight, std::uint8_t wall) {
  const int n = density_bits(sight.active[0], sight.places[0]), s = density_bits(sight.active[1], sight.places[1]);
  return {.robot = robot, .slot = CRE_READING_SLOT, .kind = wall, .value = static_cast<std::uint16_t>(n << 5 | s)};
}

const Speaker* nearest_speaker(const std::vector<Speaker>& speakers, const hal::Pose& in_ground, double radius_m) {
  const Speaker* nearest = nullptr;
  double nearest_m2 = radius_m * radius_m;
  for (const Speaker& one : speakers) {
    if (region_of(one.in_ground) == one.region) continue;
    const double m2 = kit::distance2_m2(one.in_ground, in_ground);
    if (m2 >= nearest_m2) continue;
    nearest_m2 = m2;
    nearest = &one;
  }
  return nearest;
}

std::optional<hal::ToRobot> GroundMessages::heard(hal::LabTime now, hal::RobotId robot, const hal::Pose& in_ground,
                                                  hal::Led led, const Speaker* speaker) {
  if (!speaker || led != walking) return std::nullopt;
  if (robot >= heard_.size()) heard_.resize(robot + 1u, hal::LabTime::min() / 2);
  if (now - heard_[robot] < repeat_) return std::nullopt;
  heard_[robot] = now;
  const std::uint8_t kind = speaker->region == Region::north ? CRE_HEARD_NORTH : CRE_HEARD_SOUTH;
  return hal::ToRobot{.robot = robot, .slot = CRE_HEARD_SLOT, .kind = kind, .value = compass(in_ground.heading_rad)};
}

}  // namespace arkmesh::scenarios::cre
