// Both motors: straight. One motor: a pivot about the rear leg on the side it turns to. Unequal motors: the common part
// goes straight, the rest pivots; both parts are linear in the duty.
#include "sim_ode/host/motors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hal/fixed_math.hpp"
#include "hal/platforms/kilobot/body.hpp"

namespace arkmesh::sim_ode {
namespace {

using hal::kilobot::rear_legs_apart_m;
// Ours: programs are told to stay below 90, and full power during the 15 ms of spin-up is spent on getting started.
constexpr double largest_factor = 1.5;
// At full power a motor runs after that time. Ours: kilolib.h drives for 15 ms, which is enough for every robot.
constexpr std::int64_t least_push_us = 10'000;

double factor(int duty, int calibrated) {
  if (duty == 0 || calibrated == 0) return 0;
  return std::min(largest_factor, static_cast<double>(duty) / calibrated);
}

// Nearly normal, mean 0, s.d. 1, at most 3.47: four uniform numbers from one draw. What wanders sums up many of them.
double small_push(std::uint64_t bits) {
  const auto sum = static_cast<double>((bits & 0xFFFF) + (bits >> 16 & 0xFFFF) + (bits >> 32 & 0xFFFF) + (bits >> 48));
  return (sum / 65536.0 - 2) * 1.7320508075688772;
}

}  // namespace

Motors::Motors(const DriveSettings& settings, int robots, const std::string& lab, std::uint64_t seed)
    : Motors(settings, draw_profiles(settings, robots, lab, seed), lab, seed) {}

Motors::Motors(const DriveSettings& settings, std::vector<RobotProfile> profiles, const std::string& lab,
               std::uint64_t seed)
    : settings_(settings), profiles_(std::move(profiles)), parts_(profiles_.size()) {
  const double tick_s = tick_us * 1e-6;
  const auto any = [&](auto&& is) { return std::any_of(profiles_.begin(), profiles_.end(), is); };
  if (any([](const RobotProfile& robot) { return robot.start_duty > robot.dead_duty; }))
    spin_.assign(profiles_.size(), {at_rest, at_rest});
  const bool wanders = any([](const RobotProfile& robot) { return robot.turn_noise_rad_s > 0; });
  for (std::size_t i = 0; i < profiles_.size(); ++i) {
    const RobotProfile& robot = profiles_[i];
    parts_[i].calibration = robot.duties;
    if (settings.motion_noise > 0) noise_.emplace_back(seed, lab + "/ode/motion_noise", i);
    if (!wanders) continue;
    hal::RandomStream chance(seed, lab + "/ode/turn_noise", i);
    const double keeps = robot.turn_noise_s > 0 ? hal::fixed::exp(-tick_s / robot.turn_noise_s) : 0,
                 first = robot.turn_noise_rad_s * small_push(chance.next());
    wander_.push_back({first, keeps, robot.turn_noise_rad_s * std::sqrt(1 - keeps * keeps), chance});
  }
}

// About the middle between the wheels.
Velocity Motors::on_wheels(double left_m_s, double right_m_s) const {
  const double turn = (right_m_s - left_m_s) / settings_.drive.wheels_apart_m;
  return {(left_m_s + right_m_s) / 2, turn * settings_.drive.axle_behind_m, turn};
}

Velocity Motors::velocity(int robot, int left, int right) const {
  if (settings_.drive.way == hal::RobotDrive::Way::differential)
    return on_wheels(settings_.drive.speed_m_s * right / 255, settings_.drive.speed_m_s * left / 255);
  const RobotProfile& profile = profiles_[index(robot)];
  if (left < profile.dead_duty) left = 0;
  if (right < profile.dead_duty) right = 0;
  const bool both = left > 0 && right > 0;
  const double l = factor(left, both ? profile.duties.straight_left : profile.duties.turn_left);
  const double r = factor(right, both ? profile.duties.straight_right : profile.duties.turn_right);

  Velocity out;
  out.ahead_m_s = settings_.speed_m_s * std::min(l, r);
  // the first motor pushes the right side and turns left, the second the other way round
  double turn_left = settings_.turn_rad_s * std::max(0.0, l - r);
  double turn_right = settings_.turn_rad_s * std::max(0.0, r - l);
  // what sets the robot apart adds to the speed of a moving side, as a wheel's speed would
  const double side_left = (both ? profile.straight_left_m_s : profile.pivot_left_m_s) * l;
  const double side_right = (both ? profile.straight_right_m_s : profile.pivot_right_m_s) * r;
  if (both) {
    out.ahead_m_s += (side_left + side_right) / 2;
    out.turn_rad_s += (side_left - side_right) / rear_legs_apart_m;
  } else {
    turn_left += side_left / rear_legs_apart_m;
    turn_right += side_right / rear_legs_apart_m;
  }
  // pivots: v = w x (centre - leg)
  out.turn_rad_s += turn_left - turn_right;
  out.ahead_m_s += (turn_left + turn_right) * rear_legs_apart_m / 2;
  out.left_m_s += (turn_left - turn_right) * hal::kilobot::rear_axle_m;
  return out;
}

void Motors::set(int robot, std::uint8_t left, std::uint8_t right, std::int64_t us) {
  Part& part = parts_[index(robot)];
  if (part.left == left && part.right == right) return;
  part.left = left;
  part.right = right;
  part.driven = false;
  if (part.connected) update(robot, us);
}

void Motors::drive(int robot, const hal::SetPoint& wheels) {
  Part& part = parts_[index(robot)];
  part.driven = true;
  part.wheels = wheels;
  if (part.connected) update(robot, 0);
}

void Motors::connect(int robot, bool on, std::int64_t us) {
  Part& part = parts_[index(robot)];
  if (part.connected == on) return;
  part.connected = on;
  update(robot, us);
}

void Motors::weaken(int robot, double strength) {
  Part& part = parts_[index(robot)];
  part.strength = static_cast<float>(strength);
  if (part.connected) update(robot, 0);
}

int Motors::load(int robot) const {
  const Part& part = parts_[index(robot)];
  return part.connected ? part.left + part.right : 0;
}

// With the present duties from now on: a motor that is too weak to start stands.
Velocity Motors::driven(int robot, std::int64_t us) {
  const Part& part = parts_[index(robot)];
  if (part.driven && part.connected) return on_wheels(part.wheels.left_mm_s / 1e3, part.wheels.right_mm_s / 1e3);
  const RobotProfile& profile = profiles_[index(robot)];
  int left = part.connected ? part.left : 0, right = part.connected ? part.right : 0;
  if (!spin_.empty()) {
    const auto start = [&](int duty, std::int64_t& pushed_us) {
      const std::int64_t now_us = tick_start_us_ + us;
      if (duty >= profile.start_duty && duty >= profile.dead_duty && duty > 0) {
        if (pushed_us == at_rest) pushed_us = now_us;
        return duty;
      }
      if (duty < profile.dead_duty || pushed_us == at_rest || now_us - pushed_us < least_push_us) pushed_us = at_rest;
      return pushed_us == at_rest ? 0 : duty;
    };
    left = start(left, spin_[index(robot)].left_us);
    right = start(right, spin_[index(robot)].right_us);
  }
  if (left == 0 && right == 0) return {};
  Velocity out = velocity(robot, left, right);
  out.ahead_m_s *= static_cast<double>(part.strength);
  out.left_m_s *= static_cast<double>(part.strength);
  out.turn_rad_s *= static_cast<double>(part.strength);
  return out;
}

void Motors::update(int robot, std::int64_t us) {
  Part& part = parts_[index(robot)];
  const auto lasted = static_cast<double>(us - part.since_us);
  part.sum.ahead_m_s += part.now.ahead_m_s * lasted;
  part.sum.left_m_s += part.now.left_m_s * lasted;
  part.sum.turn_rad_s += part.now.turn_rad_s * lasted;
  part.since_us = static_cast<std::int32_t>(us);
  part.loaded_moment += (load(robot) - part.loaded) * (tick_start_us_ + us);
  part.loaded = load(robot);
  part.now = driven(robot, us);
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
  tick_start_us_ += tick_us;
  if (!noise_.empty() || !wander_.empty()) add_noise();
  return out_;
}

// With noise every moving robot changes in every tick: those of the last tick and those that out_ tells of.
void Motors::add_noise() {
  noisy_.clear();
  moving_next_.clear();
  auto steady = moving_.begin();
  const auto add_steady = [&](int before) {
    for (; steady != moving_.end() && *steady < before; ++steady)
      noisy_.push_back({*steady, noisy(*steady, parts_[index(*steady)].now)}), moving_next_.push_back(*steady);
  };
  for (const Change& change : out_) {
    add_steady(change.robot);
    if (steady != moving_.end() && *steady == change.robot) ++steady;
    noisy_.push_back({change.robot, noisy(change.robot, change.velocity)});
    if (!parts_[index(change.robot)].now.still()) moving_next_.push_back(change.robot);
  }
  add_steady(std::numeric_limits<int>::max());
  moving_.swap(moving_next_);
  out_.swap(noisy_);
}

Velocity Motors::noisy(int robot, Velocity v) {
  if (v.still()) return v;
  if (!noise_.empty()) {
    hal::RandomStream& chance = noise_[index(robot)];
    const double speed = 1 + settings_.motion_noise * chance.normal(),
                 turn = 1 + settings_.motion_noise * chance.normal();
    v.ahead_m_s *= speed;
    v.left_m_s *= speed;
    v.turn_rad_s *= turn;
  }
  if (!wander_.empty()) {
    // about the middle between the rear legs or wheels, which cannot slip sideways
    Wander& wander = wander_[index(robot)];
    wander.rate_rad_s = wander.keeps * wander.rate_rad_s + wander.kick_rad_s * small_push(wander.chance.next());
    v.turn_rad_s += wander.rate_rad_s;
    v.left_m_s += wander.rate_rad_s * settings_.drive.axle_behind_m;
  }
  return v;
}

}  // namespace arkmesh::sim_ode
