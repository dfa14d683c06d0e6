// Both motors: straight. One motor: a pivot about the rear leg on the side it turns to. Unequal motors: the common part
// goes straight, the rest pivots; both parts are linear in the duty.
#include "sim_ode/host/motors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arkmesh::sim_ode {
namespace {

// ARGoS kilobot_measures.h: rear legs 25 mm apart, body centre 9.2 mm ahead of their middle.
constexpr double legs_apart_m = 0.025;
constexpr double centre_ahead_m = 0.0092;
// kilolib.h: a motor is on above 10 % duty. The upper bound is ours: programs are told to stay below 90, and full power
// during the 15 ms of spin-up is spent on getting started.
constexpr int min_duty = 26;
constexpr double largest_factor = 1.5;

double factor(int duty, int calibrated, double bias) {
  if (duty < min_duty || calibrated == 0) return 0;
  return std::min(largest_factor, static_cast<double>(duty) / calibrated) * std::max(0.0, 1 + bias);
}

std::uint8_t to_duty(double duty) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(duty), 30L, 120L));
}

}  // namespace

Motors::Motors(const DriveSettings& settings, int robots, const std::string& lab, std::uint64_t seed)
    : settings_(settings) {
  parts_.resize(index(robots));
  for (int i = 0; i < robots; ++i) {
    hal::RandomStream chance(seed, lab + "/ode/motors", static_cast<std::uint64_t>(i));
    Part& part = parts_[index(i)];
    const double left = chance.normal(), right = chance.normal();
    part.nominal.turn_left = to_duty(70 + settings.duty_spread * left);
    part.nominal.turn_right = to_duty(70 + settings.duty_spread * right);
    part.nominal.straight_left = to_duty(65 + settings.duty_spread * left);
    part.nominal.straight_right = to_duty(65 + settings.duty_spread * right);
    part.calibration = part.nominal;
    part.bias_left = static_cast<float>(settings.speed_spread * chance.normal());
    part.bias_right = static_cast<float>(settings.speed_spread * chance.normal());
    if (settings.motion_noise > 0) noise_.emplace_back(seed, lab + "/ode/motion_noise", static_cast<std::uint64_t>(i));
  }
}

Velocity Motors::velocity(int robot, std::uint8_t left, std::uint8_t right) const {
  const Part& part = parts_[index(robot)];
  const bool both = left >= min_duty && right >= min_duty;
  const double l = factor(left, both ? part.nominal.straight_left : part.nominal.turn_left, 0);
  const double r = factor(right, both ? part.nominal.straight_right : part.nominal.turn_right, 0);

  Velocity out;
  out.ahead_m_s = settings_.speed_m_s * std::min(l, r);
  // the first motor pushes the right side and turns left, the second the other way round
  double turn_left = settings_.turn_rad_s * std::max(0.0, l - r);
  double turn_right = settings_.turn_rad_s * std::max(0.0, r - l);
  // spread adds to the speed of a moving side, as a wheel's speed would
  const double side_left = l > 0 ? part.bias_left * settings_.speed_m_s * l : 0;
  const double side_right = r > 0 ? part.bias_right * settings_.speed_m_s * r : 0;
  if (both) {
    out.ahead_m_s += (side_left + side_right) / 2;
    out.turn_rad_s += (side_left - side_right) / legs_apart_m;
  } else {
    turn_left += side_left / legs_apart_m;
    turn_right += side_right / legs_apart_m;
  }
  // pivots: v = w x (centre - leg)
  out.turn_rad_s += turn_left - turn_right;
  out.ahead_m_s += (turn_left + turn_right) * legs_apart_m / 2;
  out.left_m_s += (turn_left - turn_right) * centre_ahead_m;
  return out;
}

void Motors::set(int robot, std::uint8_t left, std::uint8_t right, std::int64_t us) {
  Part& part = parts_[index(robot)];
  if (part.left == left && part.right == right) return;
  part.left = left;
  part.right = right;
  if (part.connected) update(robot, us);
}

void Motors::connect(int robot, bool on, std::int64_t us) {
  Part& part = parts_[index(robot)];
  if (part.connected == on) return;
  part.connected = on;
  update(robot, us);
}

void Motors::update(int robot, std::int64_t us) {
  Part& part = parts_[index(robot)];
  const auto lasted = static_cast<double>(us - part.since_us);
  part.sum.ahead_m_s += part.now.ahead_m_s * lasted;
  part.sum.left_m_s += part.now.left_m_s * lasted;
  part.sum.turn_rad_s += part.now.turn_rad_s * lasted;
  part.since_us = static_cast<std::int32_t>(us);
  part.now = part.connected ? velocity(robot, part.left, part.right) : Velocity{};
  if (!part.listed) {
    part.listed = true;
    changed_.push_back(robot);
  }
}

const std::vector<Motors::Change>& Motors::end_tick() {
  // both lists ascend, unless robots were spoken to out of turn
  for (std::vector<int>* list : {&changed_, &restless_})
    if (!std::is_sorted(list->begin(), list->end())) std::sort(list->begin(), list->end());
  out_.clear();
  still_restless_.clear();
  auto steady = restless_.begin();
  const auto add_steady = [&](int before) {
    // steady again since the last tick, unless they changed anew
    for (; steady != restless_.end() && *steady < before; ++steady)
      if (!parts_[index(*steady)].listed) out_.push_back({*steady, parts_[index(*steady)].now});
  };
  for (int robot : changed_) {
    add_steady(robot);
    Part& part = parts_[index(robot)];
    Velocity mean = part.now;
    if (part.since_us > 0) {  // not at the tick's very start: a mean of segments
      const auto rest = static_cast<double>(tick_us - part.since_us);
      mean.ahead_m_s = (part.sum.ahead_m_s + part.now.ahead_m_s * rest) / tick_us;
      mean.left_m_s = (part.sum.left_m_s + part.now.left_m_s * rest) / tick_us;
      mean.turn_rad_s = (part.sum.turn_rad_s + part.now.turn_rad_s * rest) / tick_us;
      still_restless_.push_back(robot);
    }
    part.sum = {};
    part.since_us = 0;
    out_.push_back({robot, mean});
  }
  add_steady(std::numeric_limits<int>::max());
  for (int robot : changed_) parts_[index(robot)].listed = false;
  changed_.clear();
  restless_.swap(still_restless_);
  if (noise_.empty()) return out_;

  // with noise every moving robot changes in every tick
  std::vector<Velocity> base(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) base[i] = parts_[i].now;
  for (const Change& change : out_) base[index(change.robot)] = change.velocity;
  out_.clear();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Velocity v = base[i];
    if (v.ahead_m_s != 0 || v.left_m_s != 0 || v.turn_rad_s != 0) {
      const double speed = 1 + settings_.motion_noise * noise_[i].normal(),
                   turn = 1 + settings_.motion_noise * noise_[i].normal();
      v.ahead_m_s *= speed;
      v.left_m_s *= speed;
      v.turn_rad_s *= turn;
    }
    out_.push_back({static_cast<int>(i), v});
  }
  return out_;
}

}  // namespace arkmesh::sim_ode
