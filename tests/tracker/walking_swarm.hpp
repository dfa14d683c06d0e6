// A swarm of Kilobots that walk, turn about a rear leg and push each other, and what imperfect cameras would see of it.
// No pictures.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "hal/platforms/kilobot/body.hpp"
#include "hal/types.hpp"
#include "tracker/follow/fused_observation.hpp"

namespace arkmesh::tracker_test {

struct SwarmSettings {
  int robots = 100;
  double width_m = 1, height_m = 1;
  double noise_m = 0.0007;      // of each coordinate
  double missed = 0.01;         // of each robot and frame
  double hidden_per_s = 0.002;  // how often something covers a robot
  double hidden_s = 0.5;
  double false_per_frame = 0.3;
  double led_on = 0.5;  // part of the time, in spells of some seconds
  double led_noise_rad = 0.09;
  double led_offset_rad = -hal::kilobot::led_bearing_rad;  // driving direction minus LED direction
  std::uint64_t seed = 1;
};

class WalkingSwarm {
 public:
  struct Robot {
    hal::Pose pose;
    double speed_m_s = 0, turn_rad_s = 0;
    double next_change_s = 0, hidden_until_s = -1;
    bool led = false;
  };

  explicit WalkingSwarm(const SwarmSettings& settings) : settings_(settings), random_(settings.seed) {
    while (static_cast<int>(robots.size()) < settings.robots) {
      Robot robot;
      robot.pose = {uniform(-settings.width_m / 2, settings.width_m / 2),
                    uniform(-settings.height_m / 2, settings.height_m / 2),
                    uniform(-std::numbers::pi, std::numbers::pi)};
      const bool free = std::none_of(robots.begin(), robots.end(), [&](const Robot& other) {
        return std::hypot(other.pose.x_m - robot.pose.x_m, other.pose.y_m - robot.pose.y_m) < 0.036;
      });
      if (free) robots.push_back(robot);
    }
  }

  // In steps of at most 20 ms.
  void walk(double seconds) {
    for (double left = seconds; left > 1e-9; left -= 0.02) step(std::min(left, 0.02));
  }

  // What cameras see of it now. Deterministic for a seed.
  std::vector<tracker::FusedObservation> look() {
    std::vector<tracker::FusedObservation> seen;
    for (Robot& robot : robots) {
      if (now_s_ < robot.hidden_until_s || chance(settings_.missed)) continue;
      tracker::FusedObservation one{.x_m = robot.pose.x_m + noise(settings_.noise_m),
                                    .y_m = robot.pose.y_m + noise(settings_.noise_m),
                                    .sigma_m = settings_.noise_m,
                                    .confidence = 0.9f,
                                    .led_confidence = 0.9f};
      if (robot.led) {
        one.led = hal::Led::green;
        one.led_heading_rad = robot.pose.heading_rad - settings_.led_offset_rad + noise(settings_.led_noise_rad);
        one.led_heading_sigma_rad = settings_.led_noise_rad;
      }
      seen.push_back(one);
    }
    std::poisson_distribution<int> strangers(settings_.false_per_frame);
    for (int i = strangers(random_); i > 0; --i)
      seen.push_back({.x_m = uniform(-settings_.width_m / 2, settings_.width_m / 2),
                      .y_m = uniform(-settings_.height_m / 2, settings_.height_m / 2),
                      .sigma_m = settings_.noise_m,
                      .confidence = 0.6f});
    std::shuffle(seen.begin(), seen.end(), random_);
    return seen;
  }

  double uniform(double low, double high) { return std::uniform_real_distribution<>(low, high)(random_); }
  double noise(double sigma) { return std::normal_distribution<>(0, sigma)(random_); }
  bool chance(double p) { return uniform(0, 1) < p; }

  std::vector<Robot> robots;

 private:
  void step(double seconds) {
    now_s_ += seconds;
    for (Robot& robot : robots) {
      if (now_s_ >= robot.next_change_s) {
        robot.next_change_s = now_s_ + uniform(1, 6);
        const double what = uniform(0, 1);
        robot.speed_m_s = what < 0.55 ? uniform(0.007, 0.013) : 0;
        robot.turn_rad_s = what < 0.55 ? noise(0.05) : what < 0.9 ? (chance(0.5) ? 1 : -1) * uniform(0.4, 0.8) : 0;
        // A robot turns about a rear leg: the axle's middle moves too.
        if (what >= 0.55 && what < 0.9)
          robot.speed_m_s = std::abs(robot.turn_rad_s) * hal::kilobot::rear_legs_apart_m / 2;
        robot.led = chance(settings_.led_on);
      }
      if (chance(settings_.hidden_per_s * seconds)) robot.hidden_until_s = now_s_ + settings_.hidden_s;
      const double along = robot.speed_m_s * seconds, aside = robot.turn_rad_s * seconds * hal::kilobot::rear_axle_m;
      hal::Pose& pose = robot.pose;
      pose.x_m += along * std::cos(pose.heading_rad) - aside * std::sin(pose.heading_rad);
      pose.y_m += along * std::sin(pose.heading_rad) + aside * std::cos(pose.heading_rad);
      pose.heading_rad = std::remainder(pose.heading_rad + robot.turn_rad_s * seconds, 2 * std::numbers::pi);
      pose.x_m = std::clamp(pose.x_m, -settings_.width_m / 2, settings_.width_m / 2);
      pose.y_m = std::clamp(pose.y_m, -settings_.height_m / 2, settings_.height_m / 2);
    }
    push_apart();
  }

  void push_apart() {
    constexpr double diameter_m = 2 * hal::kilobot::body_radius_m;
    for (std::size_t i = 0; i < robots.size(); ++i)
      for (std::size_t j = i + 1; j < robots.size(); ++j) {
        hal::Pose &a = robots[i].pose, &b = robots[j].pose;
        const double x = b.x_m - a.x_m, y = b.y_m - a.y_m, apart = std::hypot(x, y);
        if (apart >= diameter_m || apart == 0) continue;
        const double push = (diameter_m - apart) / 2 / apart;
        a.x_m -= x * push, a.y_m -= y * push, b.x_m += x * push, b.y_m += y * push;
      }
  }

  SwarmSettings settings_;
  std::mt19937_64 random_;
  double now_s_ = 0;
};

}  // namespace arkmesh::tracker_test
