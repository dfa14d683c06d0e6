// Times are microseconds of lab time. Light needs none: all robots in range hear a sender at once.
#include "sim_ode/robot_infrared.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "hal/fixed_math.hpp"
#include "sim_ode/host/turns/distance_readings.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr std::int64_t message_us = 4371;            // 130 slots of 269 cycles at 8 MHz
constexpr std::int64_t sense_until_us = 67;          // a sender that has begun by then is sensed
constexpr std::int64_t overhead_repeat_us = 10'409;  // the controller repeats its message until the next packet
constexpr double grid_slack_m = 0.005;

}  // namespace

RobotInfrared::RobotInfrared(const Settings& settings, double width_m, double height_m, int robots,
                             const std::string& lab, std::uint64_t seed)
    : InfraredMedium(robots),
      settings_(settings),
      grid_(width_m, height_m, std::max(0.02, settings.ir_range_m), robots),
      chance_(seed, lab + "/ode/infrared"),
      reach_(settings, lab, seed) {
  ears_.resize(index(robots));
}

void RobotInfrared::overhead_sends(std::int64_t start_us) {
  overhead_us_.push_back(start_us);
  if (overhead_us_.size() > 16) overhead_us_.pop_front();
}

bool RobotInfrared::overhead_on_air(std::int64_t from_us, std::int64_t to_us) const {
  if (source_) return source_->on_air(from_us, to_us);
  for (std::size_t k = overhead_us_.size(); k-- > 0;) {
    const std::int64_t begin = overhead_us_[k];
    // repeats until the next packet, or until the controller is stopped
    const std::int64_t end =
        std::min(k + 1 < overhead_us_.size() ? overhead_us_[k + 1] : INT64_MAX, begin + settings_.composite.count());
    if (end <= from_us) return false;
    if (begin >= to_us) continue;
    const std::int64_t since = std::max<std::int64_t>(0, from_us - begin);
    const std::int64_t in_period = since % overhead_repeat_us;
    if (in_period < message_us || since - in_period + overhead_repeat_us < std::min(to_us, end) - begin) return true;
  }
  return false;
}

// Few or many, they are nearly sorted by counting them into equal spans of time; what is left is put right by
// insertion.
void RobotInfrared::sort_attempts() {
  const std::size_t count = attempts_.size();
  const auto span = [&](const Attempt& attempt) {
    return static_cast<std::size_t>(std::clamp<std::int64_t>(attempt.at_us - start_us_, 0, tick_us - 1)) * count /
           tick_us;
  };
  counting_.assign(count + 1, 0);
  for (const Attempt& attempt : attempts_) ++counting_[span(attempt) + 1];
  for (std::size_t k = 1; k <= count; ++k) counting_[k] += counting_[k - 1];
  sorting_.resize(count);
  for (const Attempt& attempt : attempts_) sorting_[counting_[span(attempt)]++] = attempt;
  for (std::size_t k = 1; k < count; ++k) {
    const Attempt attempt = sorting_[k];
    std::size_t at = k;
    for (; at > 0 && sorting_[at - 1] > attempt; --at) sorting_[at] = sorting_[at - 1];
    sorting_[at] = attempt;
  }
  attempts_.swap(sorting_);
}

void RobotInfrared::forget_ended() {
  if (ended_ == 0) return;
  const std::size_t listeners = ended_ < on_air_.size() ? on_air_[ended_].first_listener : listeners_.size();
  on_air_.erase(on_air_.begin(), on_air_.begin() + static_cast<std::ptrdiff_t>(ended_));
  listeners_.erase(listeners_.begin(), listeners_.begin() + static_cast<std::ptrdiff_t>(listeners));
  for (Sending& sending : on_air_) sending.first_listener -= listeners;
  first_number_ += static_cast<std::int64_t>(ended_);
  ended_ = 0;
}

void RobotInfrared::begin_tick(std::int64_t number, const ContactWorld& world, std::span<const Offer> offers) {
  world_ = &world;
  start_us_ = number * tick_us;
  end_us_ = start_us_ + tick_us;
  forget_ended();
  // attempts of this tick: put off ones at their own time, the others at the robots' timers
  attempts_.clear();
  attempt_ = 0;
  std::erase_if(retrying_, [&](int robot) {
    if (ears_[index(robot)].retry_us >= end_us_) return false;
    attempts_.push_back({ears_[index(robot)].retry_us, robot});
    return true;
  });
  for (const Offer& offer : offers)
    if (ears_[index(offer.robot)].retry_us < 0) attempts_.push_back({start_us_ + offer.at_us, offer.robot});
  sort_attempts();

  if (!attempts_.empty() && (grid_path_m_ < 0 || world.longest_path_m() - grid_path_m_ > grid_slack_m)) {
    grid_.build(world.x(), world.y());
    grid_path_m_ = world.longest_path_m();
  }
  unsorted_.clear();
}

// The earliest one, once all messages that end before it have been heard.
std::optional<RobotInfrared::Attempt> RobotInfrared::take_attempt() {
  const bool again_first = !again_.empty() && (attempt_ == attempts_.size() || attempts_[attempt_] > again_.front());
  const bool any = again_first || attempt_ < attempts_.size();
  const Attempt first = again_first ? again_.front() : any ? attempts_[attempt_] : Attempt{};
  while (ended_ < on_air_.size() && on_air_[ended_].end_us < end_us_ && (!any || on_air_[ended_].end_us <= first.at_us))
    finish(on_air_[ended_]), ++ended_;
  if (!any) return std::nullopt;
  if (again_first) {
    std::pop_heap(again_.begin(), again_.end(), std::greater<>{});
    again_.pop_back();
  } else {
    ++attempt_;
  }
  fetch_ahead();
  return first;
}

std::optional<Outcome> RobotInfrared::next() {
  while (const std::optional<Attempt> attempt = take_attempt()) {
    Ear& ear = ears_[index(attempt->robot)];
    ear.retry_us = -1;
    // a robot that receives something puts sending off to its next tick
    if (ear.decoding >= 0 || overhead_on_air(attempt->at_us, attempt->at_us + 1)) continue;
    now_ = *attempt;
    // light that it could not decode is sensed after its own first pulse
    const bool free = ear.energy_until_us <= now_.at_us + sense_until_us;
    return Outcome{now_.robot, free ? Outcome::Channel::free : Outcome::Channel::busy};
  }
  return std::nullopt;
}

void RobotInfrared::back_off(std::uint32_t us) {
  ++totals_.backed_off;
  const std::int64_t retry_us = now_.at_us + 1 + us;
  ears_[index(now_.robot)].retry_us = retry_us;
  if (retry_us < end_us_) {
    again_.push_back({retry_us, now_.robot});
    std::push_heap(again_.begin(), again_.end(), std::greater<>{});
  } else {
    retrying_.push_back(now_.robot);
  }
}

void RobotInfrared::end_tick(std::vector<Reception>& heard) {
  // by robot; times are in order already
  heard.resize(unsorted_.size());
  if (unsorted_.empty()) return;
  first_of_.assign(ears_.size() + 1, 0);
  for (const Reception& reception : unsorted_) ++first_of_[index(reception.robot) + 1];
  for (std::size_t i = 1; i < first_of_.size(); ++i) first_of_[i] += first_of_[i - 1];
  for (const Reception& reception : unsorted_) heard[first_of_[index(reception.robot)]++] = reception;
}

// Senders follow each other in time, not in space: without this each one waits for memory several times.
void RobotInfrared::fetch_ahead() const {
  const std::size_t at = attempt_;
  const ContactWorld& world = *world_;
  const double reach = reach_.longest_m() + world.longest_path_m() - grid_path_m_;
  if (at + 6 < attempts_.size()) {
    const std::size_t i = index(attempts_[at + 6].robot);
    __builtin_prefetch(&world.x()[i]);
    __builtin_prefetch(&world.y()[i]);
    __builtin_prefetch(&ears_[i]);
  }
  if (at + 4 < attempts_.size()) {
    const std::size_t i = index(attempts_[at + 4].robot);
    grid_.fetch_cells(world.x()[i], world.y()[i], reach);
  }
  if (at + 2 < attempts_.size()) {
    const std::size_t i = index(attempts_[at + 2].robot);
    grid_.fetch_members(world.x()[i], world.y()[i], reach);
  }
}

void RobotInfrared::send(const Message& message) {
  ++totals_.sent;
  const auto [at_us, robot] = now_;
  const ContactWorld& world = *world_;
  const std::int64_t number = first_number_ + static_cast<std::int64_t>(on_air_.size()), end_us = at_us + message_us;
  const bool good_crc = message.crc == message_crc(message);
  if (!good_crc) ++totals_.bad_crc;
  if (message.type > 127) ++totals_.for_firmware;
  ears_[index(robot)].sends_until_us = end_us;

  const std::size_t first_listener = listeners_.size();
  const double x = world.x()[index(robot)], y = world.y()[index(robot)], range = reach_.longest_m();
  // they may have moved since the grid was built
  const std::span<const int> near = grid_.gather(x, y, range + world.longest_path_m() - grid_path_m_, near_);
  const bool same_for_all = reach_.same_for_all();
  const bool looks = pairs_.sends(robot, at_us);
  for (const int listener : near) {
    const double dx = world.x()[index(listener)] - x, dy = world.y()[index(listener)] - y;
    if (dx * dx + dy * dy > range * range || listener == robot) continue;
    if (!same_for_all &&
        (hal::fixed::hypot(dx, dy) > reach_.of_pair_m(robot, listener) || reach_.is_blocked(robot, listener, world)))
      continue;
    if (looks) pairs_.reaches(listener);
    Ear& ear = ears_[index(listener)];
    const bool free = ear.energy_until_us <= at_us && ear.sends_until_us <= at_us;
    // a receiver stays with the message that it has begun, and loses it: every pulse above one threshold counts
    // (firmware)
    if (!free && ear.decoding >= 0) {
      ++totals_.spoiled;
      ear.decoding = -1;
    }
    ear.energy_until_us = std::max(ear.energy_until_us, end_us);
    if (!free) continue;  // deaf while it sends, or two at once
    ear.decoding = number;
    listeners_.push_back(listener);
  }
  on_air_.push_back({robot, at_us, end_us, good_crc, message, first_listener, listeners_.size() - first_listener});
}

void RobotInfrared::finish(const Sending& sending) {
  const ContactWorld& world = *world_;
  const bool talked_over = overhead_on_air(sending.start_us, sending.end_us);
  const std::int64_t number = first_number_ + static_cast<std::int64_t>(ended_);
  const bool has_unheard = pairs_.has_unheard(sending.robot);
  for (std::size_t k = 0; k < sending.listeners; ++k) {
    const int listener = listeners_[sending.first_listener + k];
    Ear& ear = ears_[index(listener)];
    if (ear.decoding != number) continue;  // spoiled
    ear.decoding = -1;
    if (talked_over) {
      ++totals_.spoiled;
      continue;
    }
    if (!sending.good_crc) continue;
    const double dx = world.x()[index(listener)] - world.x()[index(sending.robot)],
                 dy = world.y()[index(listener)] - world.y()[index(sending.robot)];
    double distance = std::sqrt(dx * dx + dy * dy);
    if (settings_.ir_loss > 0 && chance_.uniform() < settings_.ir_loss) {
      ++totals_.lost;
      continue;
    }
    const double noise_m = settings_.ir_noise_m + settings_.air.ir_noise_per_m * distance;
    distance = reach_.measured_m(sending.robot, listener, distance);
    if (noise_m > 0) distance += noise_m * about_normal(chance_.next());
    Reception& reception = unsorted_.emplace_back();
    reception.robot = listener;
    reception.at_us = static_cast<std::uint32_t>(sending.end_us - start_us_);
    reception.message = sending.message;
    const DistanceReadings readings = readings_at(distance);
    reception.low_gain = readings.low_gain;
    reception.high_gain = readings.high_gain;
    if (has_unheard) pairs_.hears(sending.robot, listener);
    ++totals_.received;
  }
}

}  // namespace arkmesh::sim_ode
