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
  // Each robot is looked at once in so many ticks, a second: what it does then counts for all of them.
  static constexpr int looks_every = 31;
  // The first robot that is looked at in this tick; the others follow at that distance.
  static int first(std::int64_t tick) { return static_cast<int>(tick % looks_every); }
  // What it does: the sum of its duties, and of its colours' steps.
  void spend(int robot, int duties, int light);
  // Share of a full one's; a straight line from full to empty.
  double voltage(int robot) const;
  bool empty(int robot) const { return run_down() && left_mas_[static_cast<std::size_t>(robot)] <= 0; }

 private:
  BatterySettings settings_;
  std::vector<double> left_mas_;  // mA s, by robot
};

}  // namespace arkmesh::sim_ode
