#include "sim_ode/contact_world.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "hal/platforms/kilobot/body.hpp"
#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {

TEST_CASE("between two ticks a heading is between their headings, however fast robots are") {
  // At 0.2 m/s a tick is divided into seven steps. Robots turn on and on, so that headings pass the half turn.
  for (const double ahead_m_s : {0.01, 0.05, 0.2})
    for (const double turn_rad_s : {-2.3, 0.7, 2.9}) {
      ContactWorld world(100, 100, {}, 1, {{0, 0, 3}, {1, 1, -3}});
      for (const int robot : {0, 1}) world.set_velocity(robot, {ahead_m_s, 0, turn_rad_s});
      const double turn = turn_rad_s * tick_us * 1e-6;
      double furthest = 0;
      for (int tick = 0; tick < 1000; ++tick) {
        world.tick();
        for (const int robot : {0, 1}) {
          const double after = world.pose(robot, 1).heading_rad, between = world.pose(robot, 0.25).heading_rad;
          furthest = std::max(furthest, std::abs(std::remainder(after - between - 0.75 * turn, 2 * std::numbers::pi)));
        }
      }
      CAPTURE(ahead_m_s);
      CAPTURE(turn_rad_s);
      CHECK(furthest < 1e-9);
    }
}

TEST_CASE("two robots that meet head-on stay together where friction holds their rims, and else pass") {
  // A contact at angle a to their ways holds while tan a <= 3 mu: a robot's rim resists sliding by its mass and its
  // moment of a disc, 1/m + r^2/I = 3/m. What holds turns as one body, and so for ever.
  for (const double friction : {0.15, 0.3, 0.5})
    for (const double share : {0.9, 1.1}) {
      const double offset_m = 2 * hal::kilobot::body_radius_m * std::sin(std::atan(share * 3 * friction));
      ContactWorld world(4, 4, {.friction = friction}, 1,
                         {{-0.025, offset_m / 2, 0}, {0.025, -offset_m / 2, std::numbers::pi}});
      for (const int robot : {0, 1}) world.set_velocity(robot, {0.01, 0, 0});
      for (int tick = 0; tick < 60 * 1'000'000 / tick_us; ++tick) world.tick();
      const hal::Pose a = world.pose(0, 1), b = world.pose(1, 1);
      const bool together = std::hypot(a.x_m - b.x_m, a.y_m - b.y_m) < 2 * hal::kilobot::body_radius_m + 0.001;
      CAPTURE(friction);
      CHECK(together == (share < 1));
    }
}

}  // namespace arkmesh::sim_ode
