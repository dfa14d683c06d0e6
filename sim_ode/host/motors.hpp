// From motor duties to a robot's velocity: what each robot's motors do at a duty, what wanders, and what happened
// within a tick. Knows nothing of walls or neighbours.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/platforms/kilobot/body.hpp"
#include "hal/random.hpp"
#include "hal/robot/set_point.hpp"
#include "sim_ode/host/robot_profile.hpp"
#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {

// Of the body's centre, in the robot's frame.
struct Velocity {
  double ahead_m_s = 0;
  double left_m_s = 0;
  double turn_rad_s = 0;  // counter-clockwise
  bool still() const { return ahead_m_s == 0 && left_m_s == 0 && turn_rad_s == 0; }
};

// How robots drive and how far they differ, by keys of [arena.ode].
struct DriveSettings {
  double speed_m_s = 0.01;                 // speed_m_per_s, both motors at their calibrated duty
  double turn_rad_s = 0.7853981633974483;  // turn_deg_per_s, one motor at its calibrated duty
  double speed_spread = 0.186;             // speed_spread: s.d. of each motor's speed as a share of speed_m_per_s
  double duty_spread = 3;                  // duty_spread: s.d. of the calibrated duties, of 255
  double motion_noise = 0;                 // motion_noise: s.d. of a factor on speed and turn rate, drawn each tick
  double turn_noise_deg_per_s = 0;         // s.d. of a turn rate that wanders on top while a robot moves
  double turn_noise_s = 1;                 // how long it stays much the same
  int dead_duty = 26;                      // a motor stands below it; kilolib.h: "on" above 10 %
  int start_duty = 0;                      // below it a motor at rest does not start unless it is spun up
  double clock_spread = 0;                 // largest relative error of a robot's clock
  double send_spread = 0.005;              // the time between two messages of a robot is off by up to this share
  // Differential: the rest counts for programs only, whose first motor drives the right wheel, at its fastest at 255.
  hal::RobotDrive drive{.way = hal::RobotDrive::Way::vibration, .axle_behind_m = hal::kilobot::rear_axle_m};
};

class Motors {
 public:
  // Robots with their profiles, or as the spreads draw them.
  Motors(const DriveSettings& settings, std::vector<RobotProfile> profiles, const std::string& lab, std::uint64_t seed);
  Motors(const DriveSettings& settings, int robots, const std::string& lab, std::uint64_t seed);

  const std::vector<RobotProfile>& profiles() const { return profiles_; }
  Calibration& calibration(int robot) { return parts_[index(robot)].calibration; }

  // What set_motors() asks for, `us` after the start of the present tick; us never decreases within a tick.
  void set(int robot, std::uint8_t left, std::uint8_t right, std::int64_t us);
  // Speeds of the wheels of a robot that has some, from the next tick on: until its program changes its motors, or they
  // are given anew.
  void drive(int robot, const hal::SetPoint& wheels);
  // Of a robot whose motors are not connected.
  void forget_set_point(int robot) { parts_[index(robot)].driven = false; }
  // What the battery leaves of the speed from the next tick on, 0..1.
  void weaken(int robot, double strength);
  // Sum of both motors' duties, as far as they reach the motors.
  int load(int robot) const;
  // That sum, integrated over time up to the start of the present tick.
  std::int64_t load_us(int robot) const {
    const Part& part = parts_[index(robot)];
    return part.loaded * tick_start_us_ - part.loaded_moment;
  }
  // Outputs are connected while a robot's program runs.
  void connect(int robot, bool on, std::int64_t us);

  // A robot whose mean velocity over the present tick differs from that of the tick before.
  struct Change {
    int robot;
    Velocity velocity;
  };
  // To be called once after all robots' turns. Ascending robots.
  const std::vector<Change>& end_tick();

  // Velocity of motors that run steadily at these duties, noise apart.
  Velocity velocity(int robot, int left, int right) const;

 private:
  struct Part {
    Calibration calibration;  // what the program sees
    std::uint8_t left = 0, right = 0;
    bool driven = false;  // by set point
    bool connected = false;
    bool listed = false;             // in changed_
    float strength = 1;              // what the battery leaves of the speed
    std::int32_t since_us = 0;       // start of the present segment
    std::int32_t loaded = 0;         // load() in it
    std::int64_t loaded_moment = 0;  // sum of its changes, each times when it came
    hal::SetPoint wheels;            // when driven
    Velocity now;                    // with the present duties
    Velocity sum;                    // velocity x microseconds, of the tick's segments so far
  };
  // A turn rate that wanders (Ornstein-Uhlenbeck), tick by tick while its robot moves.
  struct Wander {
    double rate_rad_s, keeps, kick_rad_s;
    hal::RandomStream chance;
  };
  // When each motor was pushed out of rest, by the time of ticks and microseconds; at_rest. Used with a start_duty.
  struct Spin {
    std::int64_t left_us, right_us;
  };
  static constexpr std::int64_t at_rest = -1;
  static std::size_t index(int robot) { return static_cast<std::size_t>(robot); }
  void update(int robot, std::int64_t us);
  Velocity driven(int robot, std::int64_t us);
  Velocity on_wheels(double left_m_s, double right_m_s) const;
  void add_noise();
  Velocity noisy(int robot, Velocity v);

  DriveSettings settings_;
  std::vector<RobotProfile> profiles_;
  std::vector<Part> parts_;
  std::vector<int> changed_;  // in this tick
  std::vector<int> restless_,
      still_restless_;  // whose mean of the last tick, of this one, is not their steady velocity
  std::vector<Change> out_, noisy_;
  std::vector<hal::RandomStream> noise_;   // per robot, empty without motion_noise
  std::vector<Wander> wander_;             // per robot, empty without turn noise
  std::vector<int> moving_, moving_next_;  // with noise: ascending, after the last tick and after this one
  std::vector<Spin> spin_;                 // per robot, empty when motors start at once
  std::int64_t tick_start_us_ = 0;
};

}  // namespace arkmesh::sim_ode
