// Places, reach and response are those that Enki's Thymio2 was fitted with (Thymio2.cpp, IRSensor.h of Aseba's
// playground). A user's table for a real one and white paper: 4450 at 0 cm, 3010 at 5, 1930 at 10, 1000 at 14
// (aseba.wikidot.com/forum/t-3822185).
#include "sim_ode/proximity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "hal/fixed_math.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double far_m = 0.14;
// From the middle of the axle.
struct Sensor {
  double x_m, y_m, bearing_rad;
};
constexpr double twenty_deg = std::numbers::pi / 9;
constexpr std::array<Sensor, 7> sensors_of_thymio{{{0.062, 0.0485, 2 * twenty_deg},
                                                   {0.075, 0.0255, twenty_deg},
                                                   {0.0795, 0, 0},
                                                   {0.075, -0.0255, -twenty_deg},
                                                   {0.062, -0.0485, -2 * twenty_deg},
                                                   {-0.0295, 0.0295, std::numbers::pi},
                                                   {-0.0295, -0.0295, std::numbers::pi}}};
// Light comes back from a cone of so much each way: three rays stand for it.
constexpr double cone_rad = std::numbers::pi / 12;

double response(double distance_m) {
  constexpr double most = 4505, best_cm = 0.03, spread_cm2 = 73;
  if (distance_m > far_m) return 0;
  const double cm = 100 * distance_m;
  return most * (spread_cm2 - best_cm * best_cm) / (cm * cm - 2 * best_cm * cm + spread_cm2);
}

}  // namespace

std::optional<std::int16_t> Proximity::reading(int robot, int sensor) const {
  if (sensor < 0 || sensor >= static_cast<int>(sensors_of_thymio.size())) return {};
  const Sensor& one = sensors_of_thymio[static_cast<std::size_t>(sensor)];
  const std::pair<double, double> heading = world_.heading(robot);
  const double c = heading.first, s = heading.second;
  const double ahead_m = one.x_m - axle_behind_m_,
               x_m = world_.x()[static_cast<std::size_t>(robot)] + ahead_m * c - one.y_m * s,
               y_m = world_.y()[static_cast<std::size_t>(robot)] + ahead_m * s + one.y_m * c;
  const auto along = [&](double off_rad) {
    const double bc = hal::fixed::cos(one.bearing_rad + off_rad), bs = hal::fixed::sin(one.bearing_rad + off_rad);
    return ray(robot, x_m, y_m, c * bc - s * bs, s * bc + c * bs);
  };
  const double middle = along(0);
  // A flat surface straight ahead reads as its distance says: the outer rays' shares there are taken off again.
  const double value = response(middle) + response(along(cone_rad)) + response(along(-cone_rad)) -
                       2 * response(middle / hal::fixed::cos(cone_rad));
  return static_cast<std::int16_t>(std::lround(std::max(0.0, value)));
}

// How far away something is, or more than far_m. Goes on by as much as is clear, until nothing is.
double Proximity::ray(int robot, double x_m, double y_m, double cos, double sin) const {
  constexpr double touches_m = 1e-4;
  constexpr int most_steps = 100;  // along a wall
  double gone_m = 0;
  for (int step = 0; step < most_steps && gone_m <= far_m; ++step) {
    const double clear = clear_m(robot, x_m + gone_m * cos, y_m + gone_m * sin);
    if (clear < touches_m) return gone_m;
    gone_m += clear;
  }
  return 2 * far_m;
}

double Proximity::clear_m(int robot, double x_m, double y_m) const {
  double out = world_.solids().clearance_m(
      x_m, y_m, std::min({far_m, half_width_m_ - std::abs(x_m), half_height_m_ - std::abs(y_m)}));
  for (int other = 0; other < world_.robots(); ++other) {
    const double x = world_.x()[static_cast<std::size_t>(other)] - x_m,
                 y = world_.y()[static_cast<std::size_t>(other)] - y_m, near_m = out + body_radius_m_;
    if (other != robot && x * x + y * y < near_m * near_m) out = std::sqrt(x * x + y * y) - body_radius_m_;
  }
  return out;
}

}  // namespace arkmesh::sim_ode
