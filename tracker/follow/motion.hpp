// Where one robot is, where it looks and how it moves, from noisy observations: a Kalman filter on the plane and the
// circle. It knows how a Kilobot moves (forwards only, turning about a rear leg, so that the body's centre always moves
// when the robot turns), which is why the heading can be followed on the spot while the LED is dark.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "hal/types.hpp"
#include "tracker/follow/not_given.hpp"

namespace arkmesh::tracker {

struct MotionSettings {
  double rear_axle_m = not_given;  // how far the body's centre is ahead of the line between the rear legs
  double speed_drift = 5e-4;       // how fast the speed changes: variance per second, (m/s)^2/s
  double turn_drift = 3.2;         // how fast the turn rate changes: variance per second, (rad/s)^2/s
  double slip_m2_s = 1e-6;         // position changes that nothing explains: variance per second
  double turned_rad2_s = 0.0025;   // heading changes that nothing explains: variance per second
  // The same of a robot that touches another or a wall, which hold and turn it.
  double touching_slip_m2_s = 1e-5;
  double touching_turned_rad2_s = 0.3;
};

// How far something was seen from where motion expected it.
struct Misfit {
  double square = 0;      // per coordinate, in m^2 or rad^2
  double normalised = 0;  // by the variance that was stated: 1 on average if that is right
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
