// One line per key, ranges included.
#include "sim_ode/settings.hpp"

#include <cmath>
#include <numbers>

namespace arkmesh::sim_ode {

Settings read_settings(const hal::Section& arena, const std::filesystem::path& program) {
  Settings out;
  out.blank_leds = arena.flag("blank_leds", out.blank_leds);
  const hal::Section ode = arena.section("ode");
  out.controller = program.empty() ? ode.path("controller", "") : program;
  if (out.controller.empty()) ode.refuse("controller", "is missing; name the C file that robots run");
  out.start_in_centre = ode.choice("start", "uniform", {"uniform", "centre80"}) == "centre80";
  const std::vector<double> poses = ode.numbers("start_poses", {}, {-100, 100});
  if (poses.size() % 3 != 0)
    ode.refuse("start_poses", "must hold three numbers for each robot: x, y in metres, heading in radians");
  for (std::size_t i = 0; i < poses.size(); i += 3) out.start_poses.push_back({poses[i], poses[i + 1], poses[i + 2]});
  out.friction = ode.number("friction", out.friction, {0, 10});
  out.speed_m_s = ode.number("speed_m_per_s", out.speed_m_s, {0, 0.1});
  out.turn_rad_s = ode.number("turn_deg_per_s", 45, {0, 360}) * std::numbers::pi / 180;
  out.speed_spread = ode.number("speed_spread", out.speed_spread, {0, 0.5});
  out.duty_spread = ode.number("duty_spread", out.duty_spread, {0, 20});
  out.motion_noise = ode.number("motion_noise", out.motion_noise, {0, 0.5});
  const std::vector<double> lamps = ode.numbers("lamp", {}, {-100, 100});
  if (lamps.size() % 2 != 0) ode.refuse("lamp", "must hold two numbers for each lamp: x, y in metres");
  for (std::size_t i = 0; i < lamps.size(); i += 2) out.lamps.push_back({lamps[i], lamps[i + 1], 0});
  out.light_noise = ode.number("light_noise", out.light_noise, {0, 1023});
  out.clock_spread = ode.number("clock_spread", out.clock_spread, {0, 0.025});
  const double composite_us = std::round(ode.number("composite_s", 0.055, {0.005, 60}) * 1e6);
  out.composite = hal::LabTime{static_cast<std::int64_t>(composite_us)};
  out.overhead_loss = ode.number("overhead_loss", out.overhead_loss, {0, 1});
  out.ir_range_m = ode.number("ir_range_m", out.ir_range_m, {0, 1});
  out.ir_loss = ode.number("ir_loss", out.ir_loss, {0, 1});
  out.ir_range_spread_m = ode.number("ir_range_spread_m", out.ir_range_spread_m, {0, 0.2});
  out.ir_asymmetry = ode.number("ir_asymmetry", out.ir_asymmetry, {0, 1});
  out.ir_loss_per_m = ode.number("ir_loss_per_m", out.ir_loss_per_m, {0, 10});
  out.ir_noise_m = ode.number("ir_noise_m", out.ir_noise_m, {0, 0.1});
  return out;
}

}  // namespace arkmesh::sim_ode
