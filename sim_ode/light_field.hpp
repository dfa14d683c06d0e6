// Ambient light as robots' sensors read it: lamps, or the even light of a room without lamps, and each sensor's noise.
// Shapes cast shadows, robots' bodies none.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "hal/random.hpp"
#include "sim_ode/settings.hpp"
#include "sim_ode/shadows.hpp"

namespace arkmesh::sim_ode {

class LightField {
 public:
  LightField(const Settings& settings, int robots, const std::string& lab, std::uint64_t seed);

  // From now on lamps are dark behind these shapes, which outlive the field; null: behind nothing.
  void set_blockers(const Shadows* shadows) { shadows_ = shadows; }

  // What the robot's sensor reads now, 0..1023. Arena frame, metres; `heading` is a unit vector.
  std::int16_t reading(int robot, double x_m, double y_m, std::pair<double, double> heading);
  // The same without noise.
  double strength(double x_m, double y_m, std::pair<double, double> heading) const;

 private:
  std::vector<hal::Pose> lamps_;
  double noise_;
  const Shadows* shadows_ = nullptr;
  std::vector<hal::RandomStream> chance_;  // per robot
};

}  // namespace arkmesh::sim_ode
