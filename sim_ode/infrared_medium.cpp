#include "sim_ode/infrared_medium.hpp"

#include <utility>

#include "sim_ode/argos_infrared.hpp"
#include "sim_ode/robot_infrared.hpp"

namespace arkmesh::sim_ode {

std::unique_ptr<InfraredMedium> make_infrared(const Settings& settings, double width_m, double height_m,
                                              std::span<const RobotProfile> robots, const std::string& lab,
                                              std::uint64_t seed, const Shadows* shapes, const OverheadSource* source) {
  if (settings.infrared == InfraredRules::argos)
    return std::make_unique<ArgosInfrared>(settings, width_m, height_m, robots, lab, seed);
  const auto count = static_cast<int>(robots.size());
  std::vector<float> gains;
  for (const RobotProfile& robot : robots) gains.push_back(static_cast<float>(robot.infrared_gain));
  auto out = std::make_unique<RobotInfrared>(settings, width_m, height_m, count, lab, seed);
  out->set_gains(std::move(gains));
  out->set_blockers(shapes);
  out->listen_to(source);
  return out;
}

}  // namespace arkmesh::sim_ode
