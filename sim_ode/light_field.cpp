// The formula is that of ARGoS' Kilobot light sensor; it is no measurement of a robot.
#include "sim_ode/light_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/fixed_math.hpp"
#include "hal/platforms/kilobot/body.hpp"

namespace arkmesh::sim_ode {
namespace {

using hal::kilobot::light_sensor_bearing_rad;
constexpr double sensor_m = hal::kilobot::light_sensor_radius_m;
constexpr double room = 400;  // without lamps, everywhere
const double across = hal::fixed::cos(light_sensor_bearing_rad), along = hal::fixed::sin(light_sensor_bearing_rad);

}  // namespace

LightField::LightField(const Settings& settings, int robots, const std::string& lab, std::uint64_t seed)
    : lamps_(settings.lamps), noise_(settings.light_noise) {
  for (int i = 0; i < robots; ++i) chance_.emplace_back(seed, lab + "/ode/light", static_cast<std::uint64_t>(i));
}

double LightField::strength(double x_m, double y_m, std::pair<double, double> heading) const {
  if (lamps_.empty()) return room;
  const double out_x = heading.first * across - heading.second * along,
               out_y = heading.second * across + heading.first * along;
  double sum = 0;
  for (const hal::Pose& lamp : lamps_) {
    if (shadows_ && shadows_->between({x_m + sensor_m * out_x, y_m + sensor_m * out_y}, {lamp.x_m, lamp.y_m})) continue;
    const double dx = lamp.x_m - x_m - sensor_m * out_x, dy = lamp.y_m - y_m - sensor_m * out_y,
                 distance = std::sqrt(dx * dx + dy * dy);
    // a lamp right above shines on all sides alike
    const double angle =
        distance > 0 ? hal::fixed::acos(std::clamp((dx * out_x + dy * out_y) / distance, -1.0, 1.0)) : 0;
    sum += 1024 * hal::fixed::exp(-2 * distance) * (1 - angle / std::numbers::pi);
  }
  return sum;
}

std::int16_t LightField::reading(int robot, double x_m, double y_m, std::pair<double, double> heading) {
  const double noise = noise_ > 0 ? chance_[static_cast<std::size_t>(robot)].uniform(-noise_, noise_) : 0;
  return static_cast<std::int16_t>(std::clamp(std::floor(strength(x_m, y_m, heading) + noise + 0.5), 0.0, 1023.0));
}

}  // namespace arkmesh::sim_ode
