// What [arena.ode] preset = "measured" and "measured_0" set in place of the members' initializers, which are "ideal". A
// key that a file states wins over all. docs/model-truth.md says how well each of these is known; "held to data":
// compared by calibration/fit with data of robots, and set so that it agrees.
#include <cmath>
#include <numbers>

#include "hal/platforms/kilobot/layout.hpp"
#include "hal/robot/thymio.hpp"
#include "sim_ode/host/programs/object_build.hpp"
#include "sim_ode/settings.hpp"

namespace arkmesh::sim_ode {

namespace {

// Two wheels instead of motors that vibrate, words at a Thymio's rate, and no infrared between robots.
Settings thymios() {
  const hal::RobotKind kind = hal::thymio();
  Settings s;
  s.robot = Robot::thymio;
  s.drive = kind.drive;
  s.speed_spread = s.duty_spread = 0;
  s.dead_duty = 1;
  s.controller.paths = {kilolib_folder() / "thymio.c"};
  s.composite = hal::LabTime(std::llround(1e6 * hal::kilobot::groups / kind.words_per_s));
  s.ir_range_m = 0;
  s.contacts.body_radius_m = kind.body_radius_m;
  s.contacts.push_n = 1.3;      // assumption: half of its weight of 270 g, on two wheels
  s.contacts.speed_m_s = 0.01;  // assumption: its wheels, which are held at their speed, slip by so much then
  return s;
}

}  // namespace

Settings settings_of(Preset preset, Robot robot) {
  if (robot == Robot::thymio) return thymios();
  Settings s;
  s.preset = preset;
  if (preset == Preset::ideal) return s;

  // drive
  s.turn_deg_per_s = 36;       // comments of user programs for real robots: 28.5, 36, 38; ICRA 2012 "about 45"
  s.speed_spread = 0.12;       // held to data
  s.duty_spread = 3;           // labs page: turns 60 to 75, straight 2 to 10 lower
  s.turn_noise_deg_per_s = 2;  // held to data
  s.turn_noise_s = 2;          // held to data
  s.dead_duty = 40;            // assumption, between kilolib.h (10 %: 26) and Kilombo (67)
  s.start_duty = 50;  // labs page: the lowest calibrated duty, straight; kilolib.h has spinup_motors() for less
  // battery
  s.battery_mah = 160;           // ICRA 2012
  s.battery_idle_ma = 6.7;       // ICRA 2012: 24 h at least activity
  s.battery_motor_ma = 16;       // with the LED's: ICRA 2012, 3 h at most activity, 53 mA; how it divides is assumed
  s.battery_led_ma = 1.6;        // see above
  s.battery_empty_share = 0.81;  // assumption: one lithium cell, 4.2 V to ICRA 2012's 3.4 V
  // clock
  s.clock_spread = 0.005;  // held to data
  // infrared, a line each
  s.ir_range_m = 0.1215;           // held to data
  s.ir_range_spread_m = 0.019;     // held to data
  s.air.ir_noise_per_m = 0.02;     // Kilombo's authors saw noise grow; its size is an assumption
  s.air.ir_flat_m = 0.1;           // Kilombo's authors saw readings flatten there; the curve is an assumption
  s.air.ir_reading_spread = 0.03;  // ICRA 2012: accuracy 2 mm, taken at 7 cm by assumption
  // overhead controller
  s.air.overhead_loss_edge = 0.05;     // assumption
  if (preset == Preset::measured_0) {  // before the fit
    s.speed_spread = 0.186;
    s.turn_noise_deg_per_s = 3;
    s.turn_noise_s = 1;
    s.start_duty = 60;
    s.ir_range_m = 0.1;
    s.ir_range_spread_m = 0.0085;
  }
  s.turn_rad_s = s.turn_deg_per_s * std::numbers::pi / 180;
  return s;
}

}  // namespace arkmesh::sim_ode
