#include "tracker/follow/motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace arkmesh::tracker {
namespace {

constexpr double unknown_heading_variance = std::numbers::pi * std::numbers::pi;
constexpr double longest_step_s = 0.05;   // the model is linear enough over this
constexpr double speed_memory_s = 2;      // a robot out of sight is thought to stop in about this time
constexpr double hand_speed_m_s = 0.02;   // how fast a robot of unknown heading is allowed to drift
constexpr double telling_path_m = 0.005;  // a path this long tells the heading
constexpr double lit_for_s = 0.3;         // after it told the heading, an LED counts as lit
constexpr double other_light_rad = 0.25;  // a look less far off shows the robot's own LED, which has begun to turn
constexpr double anchor_life_s = 3;       // slower than that it tells nothing

Misfit misfit_of(double off, double variance) {
  const double square = off * off, normalised = square / variance;
  return {square, normalised, (normalised + std::log(2 * std::numbers::pi * variance)) / 2};
}

}  // namespace

double wrapped(double angle_rad) {
  const double turns = std::remainder(angle_rad, 2 * std::numbers::pi);
  return turns <= -std::numbers::pi ? turns + 2 * std::numbers::pi : turns;
}

Motion::Motion(double x_m, double y_m, double sigma_m, const MotionSettings& settings) : settings_(settings) {
  jump(x_m, y_m, sigma_m);
}

void Motion::jump(double x_m, double y_m, double sigma_m) {
  state_[x] = x_m;
  state_[y] = y_m;
  spread_.setZero();
  spread_(x, x) = spread_(y, y) = sigma_m * sigma_m;
  forget_heading();
}

// Keeps the old value as the best guess there is.
void Motion::forget_heading() {
  state_[speed] = state_[turn] = 0;
  for (const int i : {static_cast<int>(heading), static_cast<int>(speed), static_cast<int>(turn)}) {
    spread_.row(i).setZero();
    spread_.col(i).setZero();
  }
  spread_(heading, heading) = unknown_heading_variance;
  heading_known_ = false;
  anchor_x_m_ = state_[x];
  anchor_y_m_ = state_[y];
  since_anchor_s_ = misfit_ = 0;
  odd_headings_ = backwards_ = 0;
}

void Motion::predict(double seconds, bool touching) {
  touching_ = touching;
  since_led_s_ += seconds;
  since_anchor_s_ += seconds;
  // A very long absence teaches nothing more.
  for (double left = std::min(seconds, 60.0); left > 0; left -= longest_step_s)
    predict_step(std::min(left, longest_step_s));
}

const Unexplained& Motion::unexplained() const {
  const bool lit = since_led_s_ < lit_for_s;
  if (touching_) return lit ? settings_.touching_lit : settings_.touching_dark;
  return lit ? settings_.lit : settings_.dark;
}

void Motion::predict_step(double seconds) {
  const Unexplained& noise = unexplained();
  if (!heading_known_) {
    spread_(x, x) += hand_speed_m_s * hand_speed_m_s * seconds * 0.1 + noise.slip_m2_s * seconds;
    spread_(y, y) += hand_speed_m_s * hand_speed_m_s * seconds * 0.1 + noise.slip_m2_s * seconds;
    return;
  }
  const double middle = state_[heading] + state_[turn] * seconds / 2;
  const double c = std::cos(middle), s = std::sin(middle), axle = settings_.rear_axle_m;
  const double along_x = state_[speed] * c - axle * state_[turn] * s,
               along_y = state_[speed] * s + axle * state_[turn] * c;
  const double keep = std::exp(-seconds / speed_memory_s);

  Spread change = Spread::Identity();
  change(x, heading) = -along_y * seconds;
  change(y, heading) = along_x * seconds;
  change(x, speed) = c * seconds;
  change(y, speed) = s * seconds;
  change(x, turn) = -axle * s * seconds - along_y * seconds * seconds / 2;
  change(y, turn) = axle * c * seconds + along_x * seconds * seconds / 2;
  change(heading, turn) = seconds;
  change(speed, speed) = change(turn, turn) = keep;

  state_[x] += along_x * seconds;
  state_[y] += along_y * seconds;
  state_[heading] = wrapped(state_[heading] + state_[turn] * seconds);
  state_[speed] *= keep;
  state_[turn] *= keep;

  spread_ = change * spread_ * change.transpose();
  spread_(x, x) += noise.slip_m2_s * seconds;
  spread_(y, y) += noise.slip_m2_s * seconds;
  spread_(heading, heading) += noise.turned_rad2_s * seconds;
  spread_(speed, speed) += noise.speed * seconds;
  spread_(turn, turn) += noise.turn * seconds;
  tidy();
}

void Motion::correct(const Eigen::Matrix<double, 1, 5>& seen, double surprise, double variance) {
  const State column = spread_ * seen.transpose();
  const double total = (seen * column)(0, 0) + variance;
  const State gain = column / total;
  state_ += gain * surprise;
  state_[heading] = wrapped(state_[heading]);
  // Joseph's form: stays symmetric and positive whatever the rounding.
  const Spread rest = Spread::Identity() - gain * seen;
  spread_ = rest * spread_ * rest.transpose() + gain * variance * gain.transpose();
}

std::optional<Misfit> Motion::see_place(double x_m, double y_m, double sigma_m) {
  const double variance = sigma_m * sigma_m;
  std::optional<Misfit> misfit;
  if (heading_known_) {
    const double off_x = x_m - state_[x], off_y = y_m - state_[y];
    const Misfit along = misfit_of(off_x, spread_(x, x) + variance),
                 across = misfit_of(off_y, spread_(y, y) + variance);
    misfit = {(along.square + across.square) / 2, (along.normalised + across.normalised) / 2,
              (along.nats + across.nats) / 2};
    doubt_heading(misfit->normalised);
  }
  Eigen::Matrix<double, 1, 5> seen = Eigen::Matrix<double, 1, 5>::Zero();
  seen(0, x) = 1;
  correct(seen, x_m - state_[x], variance);
  seen(0, x) = 0;
  seen(0, y) = 1;
  correct(seen, y_m - state_[y], variance);
  if (!heading_known_)
    learn_heading_from_motion(x_m, y_m, sigma_m);
  else
    turn_round();
  tidy();
  return misfit;
}

// The path's direction: within the 36 degrees that a turn about one rear leg makes between path and heading.
void Motion::learn_heading_from_motion(double seen_x_m, double seen_y_m, double sigma_m) {
  const double along_x = seen_x_m - anchor_x_m_, along_y = seen_y_m - anchor_y_m_,
               path_m = std::hypot(along_x, along_y);
  if (touching_) {
    anchor_x_m_ = seen_x_m;
    anchor_y_m_ = seen_y_m;
    since_anchor_s_ = 0;
  } else if (path_m > std::max(telling_path_m, 6 * sigma_m)) {
    heading_known_ = true;
    state_[heading] = std::atan2(along_y, along_x);
    state_[speed] = std::min(path_m / std::max(since_anchor_s_, 0.1), 0.1);
    state_[turn] = 0;
    spread_(heading, heading) = 0.36;
    spread_(speed, speed) = 1e-4;
    spread_(turn, turn) = 0.5;
  } else if (since_anchor_s_ > anchor_life_s) {
    anchor_x_m_ = state_[x];
    anchor_y_m_ = state_[y];
    since_anchor_s_ = 0;
  }
}

// Places that keep surprising although no LED speaks for the heading: the heading is wrong.
void Motion::doubt_heading(double misfit) {
  misfit_ += 0.1 * (std::min(misfit, 20.0) - misfit_);
  if (misfit_ > 6 && since_led_s_ > 1) forget_heading();
}

// Kilobots cannot drive backwards: one that seems to is seen the wrong way round.
void Motion::turn_round() {
  const bool backwards = state_[speed] < -0.003 && since_led_s_ > 0.5 && !touching_;
  backwards_ = backwards ? backwards_ + 1 : 0;
  if (backwards_ < 5) return;
  state_[heading] = wrapped(state_[heading] + std::numbers::pi);
  state_[speed] = -state_[speed];
  spread_.row(speed) *= -1;
  spread_.col(speed) *= -1;
  spread_(heading, heading) += 0.25;
  backwards_ = 0;
}

std::optional<Misfit> Motion::see_heading(double heading_rad, double sigma_rad) {
  const double variance = sigma_rad * sigma_rad;
  const double surprise = wrapped(heading_rad - state_[heading]);
  const bool odd = heading_known_ &&
                   std::abs(surprise) > std::max(other_light_rad, 4 * std::sqrt(spread_(heading, heading) + variance));
  odd_headings_ = odd ? odd_headings_ + 1 : 0;
  // A single one is a neighbour's light; three in a row are right.
  if (odd && odd_headings_ < 3) return {};
  since_led_s_ = 0;
  if (!heading_known_ || odd) {
    forget_heading();
    heading_known_ = true;
    state_[heading] = wrapped(heading_rad);
    spread_(heading, heading) = variance;
    spread_(speed, speed) = 2e-4;
    spread_(turn, turn) = 0.5;
    return {};
  }
  const Misfit misfit = misfit_of(surprise, spread_(heading, heading) + variance);
  Eigen::Matrix<double, 1, 5> seen = Eigen::Matrix<double, 1, 5>::Zero();
  seen(0, heading) = 1;
  correct(seen, surprise, variance);
  tidy();
  return misfit;
}

void Motion::tidy() {
  state_[speed] = std::clamp(state_[speed], -0.1, 0.1);
  state_[turn] = std::clamp(state_[turn], -6.0, 6.0);
  if (spread_(heading, heading) <= unknown_heading_variance) return;
  // Nothing is known of the heading any more; neither can it be tied to anything else.
  forget_heading();
}

hal::Pose Motion::pose() const {
  return {state_[x], state_[y], state_[heading]};
}
double Motion::place_sigma_m() const {
  return std::sqrt(std::max(spread_(x, x), spread_(y, y)));
}
double Motion::heading_sigma_rad() const {
  return std::min(std::numbers::pi, std::sqrt(spread_(heading, heading)));
}
double Motion::speed_m_s() const {
  return state_[speed];
}

}  // namespace arkmesh::tracker
