// Where one robot is, where it looks and how it moves, from noisy observations: a Kalman filter on the plane and the
// circle. It knows how a Kilobot moves (forwards only, turning about a rear leg, so that the body's centre always moves
// when the robot turns), which is why the heading can be followed on the spot while the LED is dark.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "hal/types.hpp"
#include "tracker/follow/not_given.hpp"

namespace arkmesh::tracker {

// What nothing explains of a robot's motion: variances per second.
struct Unexplained {
  double speed;          // how fast the speed changes, (m/s)^2/s
  double turn;           // how fast the turn rate changes, (rad/s)^2/s
  double slip_m2_s;      // changes of the position
  double turned_rad2_s;  // changes of the heading
};

// Of robots whose LED tells the heading, the values are those that make what is seen likeliest in a film of real robots
// and of 100 emulated ones (motion_noise SECONDS --fit finds them again), but of speed and turn four times those: with
// the likeliest, starts and stops are followed too late under several cameras by turns (centres 0.25 mm RMS instead of
// 0.22, headings 0.69 degrees instead of 0.64).
// Dark robots' are set by hand: places alone do not tell how far a held robot turns, and with the values that are
// likeliest for the places of emulated ones ({7.5e-6, 0.02, 2e-7}) headings are twice as wrong, as starts of turns are
// followed too late.
struct MotionSettings {
  double rear_axle_m = not_given;  // how far the body's centre is ahead of the line between the rear legs
  Unexplained lit{2.6e-5, 0.28, 1.2e-7, 0.0012};
  Unexplained dark{5e-4, 3.2, 3e-6, 0.0025};
  // The same of a robot that touches another or a wall, which hold and turn it.
  Unexplained touching_lit{2.6e-5, 0.28, 2.5e-7, 0.007};
  Unexplained touching_dark{5e-4, 3.2, 1e-5, 0.3};
};

// How far something was seen from where motion expected it.
struct Misfit {
  double square = 0;      // per coordinate, in m^2 or rad^2
  double normalised = 0;  // by the variance that was stated: 1 on average if that is right
  double nats = 0;        // how unlikely it was per coordinate: minus the logarithm of the density that was stated
};
// Of so many: the sums.
struct Misfits {
  std::uint64_t n = 0;
  Misfit sum;
  void add(const Misfit& one) { ++n, sum.square += one.square, sum.normalised += one.normalised, sum.nats += one.nats; }
};

class Motion {
 public:
  // A robot first seen at that place, of unknown heading.
  Motion(double x_m, double y_m, double sigma_m, const MotionSettings& settings);

  // Lets time pass, at least 0. `touching`: the robot touches something.
  void predict(double seconds, bool touching = false);
  // The centre was seen; standard deviation of each coordinate. Nothing: its motion was not known.
  std::optional<Misfit> see_place(double x_m, double y_m, double sigma_m);
  // The driving direction was seen (LED direction with its offset). Nothing: there was none before, or the LED was
  // not believed.
  std::optional<Misfit> see_heading(double heading_rad, double sigma_rad);
  // Somebody has moved the robot there: speed and heading start anew.
  void jump(double x_m, double y_m, double sigma_m);

  hal::Pose pose() const;
  double place_sigma_m() const;      // the larger axis
  double heading_sigma_rad() const;  // pi when the heading is not known at all
  double speed_m_s() const;

 private:
  enum { x, y, heading, speed, turn };
  using State = Eigen::Matrix<double, 5, 1>;
  using Spread = Eigen::Matrix<double, 5, 5>;

  const Unexplained& unexplained() const;
  void predict_step(double seconds);
  void correct(const Eigen::Matrix<double, 1, 5>& seen, double surprise, double variance);
  void learn_heading_from_motion(double seen_x_m, double seen_y_m, double sigma_m);
  void doubt_heading(double misfit);
  void turn_round();
  void tidy();
  void forget_heading();

  MotionSettings settings_;
  State state_ = State::Zero();
  Spread spread_ = Spread::Zero();
  bool heading_known_ = false;
  bool touching_ = false;      // what it does need not be what its motors want
  double since_led_s_ = 1e9;   // since the LED last told the heading
  double since_anchor_s_ = 0;  // heading unknown: since the robot was at the anchor
  double anchor_x_m_ = 0, anchor_y_m_ = 0;
  int backwards_ = 0;     // observations in a row that seem to drive backwards
  double misfit_ = 0;     // running mean of squared normalised surprise
  int odd_headings_ = 0;  // LED headings in a row that do not fit
};

// In (-pi, pi].
double wrapped(double angle_rad);

}  // namespace arkmesh::tracker
