// What a Thymio's seven proximity sensors read: rays to the nearest wall, obstacle, object or robot. Robots are discs,
// walls and obstacles are as high as needed, and readings have no noise.
#pragma once

#include <cstdint>
#include <optional>

#include "sim_ode/contact_world.hpp"

namespace arkmesh::sim_ode {

class Proximity {
 public:
  // The world outlives this. `axle_behind_m`: of the wheels, behind the body's centre.
  Proximity(const ContactWorld& world, double width_m, double height_m, double body_radius_m, double axle_behind_m)
      : world_(world),
        half_width_m_(width_m / 2),
        half_height_m_(height_m / 2),
        body_radius_m_(body_radius_m),
        axle_behind_m_(axle_behind_m) {}

  // As Aseba's prox.horizontal: 0 nothing. None: no such sensor.
  std::optional<std::int16_t> reading(int robot, int sensor) const;

 private:
  double ray(int robot, double x_m, double y_m, double cos, double sin) const;
  double clear_m(int robot, double x_m, double y_m) const;

  const ContactWorld& world_;
  double half_width_m_, half_height_m_, body_radius_m_, axle_behind_m_;
};

}  // namespace arkmesh::sim_ode
