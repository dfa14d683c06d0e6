// Ambient light as robots' sensors read it: lamps, or the even light of a room without lamps, and each sensor's noise.
// Bodies cast no shadows.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "hal/random.hpp"
#include "sim_ode/settings.hpp"

namespace arkmesh::sim_ode {

class LightField {
 public:
  LightField(const Settings& settings, int robots, const std::string& lab, std::uint64_t seed);

  // What the robot's sensor reads now, 0..1023. Arena frame, metres; `heading` is a unit vector.
  std::int16_t reading(int robot, double x_m, double y_m, std::pair<double, double> heading);
  // The same without noise.
  double strength(double x_m, double y_m, std::pair<double, double> heading) const;

 private:
  std::vector<hal::Pose> lamps_;
  double noise_;
  std::vector<hal::RandomStream> chance_;  // per robot
};

}  // namespace arkmesh::sim_ode
