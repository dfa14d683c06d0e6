#include "scenarios/kit/others.hpp"

namespace arkmesh::scenarios::kit {

using Presence = lab::SensorConfig::Presence;

std::vector<Seen> others_in(const lab::Lab& lab) {
  std::vector<Seen> out;
  if (lab.sensors().presence == Presence::none) return out;
  for (const std::string& each : lab.labs()) {
    if (each == lab.name()) continue;
    for (const lab::SharedRobot& robot : lab.state(each).robots) {
      const hal::Pose at = lab.projection().to_arena(robot.in_shared);
      out.push_back({{at.x_m, at.y_m}, robot.led});
    }
  }
  return out;
}

std::vector<Surroundings::Disc> no_walk_zones(const lab::Lab& lab) {
  if (lab.sensors().presence != Presence::no_walk) return {};
  const double given_m = lab.sensors().no_walk_m;
  return discs_around(others_in(lab), given_m > 0 ? given_m : 2 * lab.arena().body_radius_m);
}

std::vector<Surroundings::Disc> discs_around(const std::vector<Seen>& robots, double radius_m) {
  std::vector<Surroundings::Disc> out;
  for (const Seen& robot : robots) out.push_back({robot.place, radius_m});
  return out;
}

}  // namespace arkmesh::scenarios::kit
