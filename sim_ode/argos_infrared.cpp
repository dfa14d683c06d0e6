#include "sim_ode/argos_infrared.hpp"

#include <algorithm>
#include <utility>

#include "hal/fixed_math.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr int most_heard = 4;  // by a robot in a tick

}  // namespace

ArgosInfrared::ArgosInfrared(const Settings& settings, double width_m, double height_m,
                             std::span<const RobotProfile> robots, const std::string& lab, std::uint64_t seed)
    : InfraredMedium(static_cast<int>(robots.size())),
      tick_us_(settings.argos_tick.count()),
      ignore_conflicts_(settings.argos_ignore_conflicts),
      loss_(settings.ir_loss),
      grid_(width_m, height_m, std::max(0.02, settings.ir_range_m), static_cast<int>(robots.size())),
      chance_(seed, lab + "/ode/argos_infrared"),
      robots_(robots.size()) {
  for (std::size_t i = 0; i < robots.size(); ++i) {
    // there it is a float, so that 0.1 m is within 0.1 m
    robots_[i].range_m = static_cast<float>(settings.ir_range_m * robots[i].infrared_gain);
    longest_m_ = std::max(longest_m_, robots_[i].range_m);
  }
}

bool ArgosInfrared::repeats(const Inbox::Overhead& said) {
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (said.reaches(static_cast<int>(i))) robots_[i].told = said.message;
  return true;
}

void ArgosInfrared::begin_tick(std::int64_t number, const ContactWorld& world, std::span<const Offer> offers) {
  world_ = &world;
  start_us_ = number * tick_us;
  end_us_ = start_us_ + tick_us;
  offers_ = offers;
  heard_.clear();
  for (const Offer& offer : offers)
    if (robots_[index(offer.robot)].clock_tick < 0) robots_[index(offer.robot)].clock_tick = ticks_;
}

// ARGoS asks robots at a tick's end, once they have heard and their programs have run: in the robots' next tick.
std::optional<Outcome> ArgosInfrared::next() {
  for (;;) {
    if (told_ < outcomes_.size()) {
      now_ = outcomes_[told_].robot;
      return outcomes_[told_++];
    }
    outcomes_.clear();
    told_ = 0;
    const bool due = (ticks_ + 1) * tick_us_ < end_us_;
    if (to_ask_us_ >= 0 && (due || to_ask_us_ < start_us_))
      ask();
    else if (due)
      run_tick();
    else
      return std::nullopt;
  }
}

void ArgosInfrared::ask() {
  to_ask_us_ = -1;
  for (const Offer& offer : offers_) {
    const Robot& robot = robots_[index(offer.robot)];
    if (!robot.waiting && (ticks_ - robot.clock_tick) * tick_us_ > offer.period * 1000)
      outcomes_.push_back({offer.robot, Outcome::Channel::waits});
  }
}

std::span<const int> ArgosInfrared::near(int robot) {
  return grid_.gather(world_->x()[index(robot)], world_->y()[index(robot)], longest_m_, near_);
}

double ArgosInfrared::between_m(int a, int b) const {
  return hal::fixed::hypot(world_->x()[index(a)] - world_->x()[index(b)],
                           world_->y()[index(a)] - world_->y()[index(b)]);
}

void ArgosInfrared::run_tick() {
  ++ticks_;
  to_ask_us_ = start_us_;
  grid_.build(world_->x(), world_->y());
  for (const Offer& offer : offers_)
    robots_[index(offer.robot)].tries = robots_[index(offer.robot)].waiting.has_value();
  winners_.clear();
  for (const auto& [robot, at_us, period] : offers_) {
    if (!robots_[index(robot)].tries) continue;
    int others = 0;
    for (const int other : near(robot))
      others +=
          other != robot && robots_[index(other)].tries && between_m(robot, other) < robots_[index(other)].range_m;
    if (ignore_conflicts_ || chance_.uniform() * (others + 1) < 1)
      winners_.push_back(robot);
    else
      ++totals_.backed_off;
  }
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    robots_[i].tries = false;
    robots_[i].heard = 0;
    if (robots_[i].told) hear(static_cast<int>(i), *robots_[i].told, 0);
  }
  for (const int winner : winners_) carry(winner);
}

void ArgosInfrared::hear(int robot, const Message& message, int distance_mm) {
  ++robots_[index(robot)].heard;
  heard_.push_back({.robot = robot,
                    .at_us = static_cast<std::uint32_t>(ticks_ * tick_us_ - start_us_),
                    .low_gain = 0,
                    .high_gain = static_cast<std::int16_t>(distance_mm),
                    .message = message});
}

void ArgosInfrared::carry(int sender) {
  Robot& from = robots_[index(sender)];
  ++totals_.sent;
  const bool looks = pairs_.sends(sender, ticks_ * tick_us_);
  for (const int listener : near(sender)) {
    Robot& to = robots_[index(listener)];
    const double distance_m = between_m(sender, listener);
    // one of shorter range does not hear beyond its own
    if (listener == sender || distance_m >= std::min(from.range_m, to.range_m)) continue;
    if (looks) pairs_.reaches(listener);
    if (loss_ > 0 && chance_.uniform() < loss_) {
      ++totals_.lost;
    } else if (to.heard == most_heard) {
      ++totals_.crowded;
    } else {
      hear(listener, *from.waiting, static_cast<int>(distance_m * 1000));
      ++totals_.received;
      if (pairs_.has_unheard(sender)) pairs_.hears(sender, listener);
    }
  }
  from.waiting.reset();
  from.clock_tick = ticks_;
  outcomes_.push_back({sender, Outcome::Channel::gone});
}

void ArgosInfrared::end_tick(std::vector<Reception>& heard) {
  std::ranges::stable_sort(heard_, {}, &Reception::robot);
  heard.swap(heard_);
}

}  // namespace arkmesh::sim_ode
