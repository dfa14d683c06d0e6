// From motor duties to a robot's velocity: calibration and spread of each robot, and what happened within a tick.
// Knows nothing of walls or neighbours.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/random.hpp"
#include "sim_ode/host/reception.hpp"

namespace arkmesh::sim_ode {

// Of the body's centre, in the robot's frame.
struct Velocity {
  double ahead_m_s = 0;
  double left_m_s = 0;
  double turn_rad_s = 0;  // counter-clockwise
};

// Duties (0..255) at which a robot turns and goes straight at its nominal speeds; kept through a reset.
struct Calibration {
  std::uint8_t turn_left = 70, turn_right = 70, straight_left = 65, straight_right = 65;
  bool operator==(const Calibration&) const = default;
};

// How robots drive, by keys of [arena.ode].
struct DriveSettings {
  double speed_m_s = 0.01;                 // speed_m_per_s, both motors at their calibrated duty
  double turn_rad_s = 0.7853981633974483;  // turn_deg_per_s, one motor at its calibrated duty
  double speed_spread = 0.186;             // speed_spread: s.d. of each motor's speed as a share of speed_m_per_s
  double duty_spread = 3;                  // duty_spread: s.d. of the calibrated duties, of 255
  double motion_noise = 0;                 // motion_noise: s.d. of a factor on speed and turn rate, drawn each tick
};

class Motors {
 public:
  Motors(const DriveSettings& settings, int robots, const std::string& lab, std::uint64_t seed);

  Calibration& calibration(int robot) { return parts_[index(robot)].calibration; }

  // What set_motors() asks for, `us` after the start of the present tick; us never decreases within a tick.
  void set(int robot, std::uint8_t left, std::uint8_t right, std::int64_t us);
  // Outputs are connected while a robot's program runs.
  void connect(int robot, bool on, std::int64_t us);

  // A robot whose mean velocity over the present tick differs from that of the tick before.
  struct Change {
    int robot;
    Velocity velocity;
  };
  // To be called once after all robots' turns. Ascending robots.
  const std::vector<Change>& end_tick();

  // Velocity at steady duties, noise apart.
  Velocity velocity(int robot, std::uint8_t left, std::uint8_t right) const;

 private:
  struct Part {
    Calibration calibration;              // what the program sees
    Calibration nominal;                  // what is true
    float bias_left = 0, bias_right = 0;  // of each motor's speed, share of nominal
    std::uint8_t left = 0, right = 0;
    bool connected = false;
    bool listed = false;        // in changed_
    Velocity now;               // with the present duties
    Velocity sum;               // velocity x microseconds, of the tick's segments so far
    std::int32_t since_us = 0;  // start of the present segment
  };
  static std::size_t index(int robot) { return static_cast<std::size_t>(robot); }
  void update(int robot, std::int64_t us);

  DriveSettings settings_;
  std::vector<Part> parts_;
  std::vector<int> changed_;  // in this tick
  std::vector<int> restless_,
      still_restless_;  // whose mean of the last tick, of this one, is not their steady velocity
  std::vector<Change> out_;
  std::vector<hal::RandomStream> noise_;  // per robot, empty without noise
};

}  // namespace arkmesh::sim_ode
