// The robots' batteries: what each robot does takes its charge, and the voltage that is left slows its motors and is
// what its program reads.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/config/config.hpp"
#include "sim_ode/host/robot_profile.hpp"

namespace arkmesh::sim_ode {

struct BatterySettings {
  double battery_mah = 0;             // of a full one; 0: it never runs down
  double battery_idle_ma = 6.7;       // what a robot takes that runs and neither moves nor shines
  double battery_motor_ma = 16;       // one motor at a duty of 70; in proportion to the duty
  double battery_led_ma = 1.6;        // each step of 0..3 of each of the LED's colours
  double battery_empty_share = 0.81;  // voltage of an empty battery as a share of a full one's

  void fields(const hal::Section& ode);
};

class Batteries {
 public:
  Batteries(const BatterySettings& settings, const std::vector<RobotProfile>& profiles);

  bool run_down() const { return settings_.battery_mah > 0; }
  // Each robot is looked at once in so many ticks, a second.
  static constexpr int looks_every = 31;
  // The first robot that is looked at in this tick; the others follow at that distance.
  static int first(std::int64_t tick) { return static_cast<int>(tick % looks_every); }
  // What it has done since it was looked at: the sums of its duties, and of its colours' steps, integrated over all
  // time.
  void spend(int robot, std::int64_t duties_us, std::int64_t light_us);
  // Share of a full one's; a straight line from full to empty.
  double voltage(int robot) const;
  bool empty(int robot) const { return run_down() && robots_[static_cast<std::size_t>(robot)].left_mas <= 0; }

 private:
  BatterySettings settings_;
  struct Robot {
    double left_mas;  // mA s
    std::int64_t duties_us = 0, light_us = 0;
  };
  std::vector<Robot> robots_;
};

}  // namespace arkmesh::sim_ode
