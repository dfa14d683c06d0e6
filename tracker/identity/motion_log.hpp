// Where one robot was lately, and what its path says: how fast, whether it came back, how straight. Knows positions
// only: they are right also while a LED is off.
#pragma once

#include <optional>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::tracker {

class MotionLog {
 public:
  void clear() { places_.clear(); }
  // `at` ascending.
  void add(hal::LabTime at, double x_m, double y_m) {
    places_.push_back({static_cast<double>(at.count()) * 1e-6, x_m, y_m});
  }
  double lasted_s() const { return places_.empty() ? 0 : places_.back().at_s - places_.front().at_s; }

  // Length of the path of the last `window_s` by time, in steps of 0.4 s: the noise of single pictures is no motion. 0
  // when it is too short.
  double path_speed_m_s(double window_s) const;
  // From the first to the last place, by time.
  double net_speed_m_s() const;
  // Seconds until it came back within `near_m` of its first place after it was farther away than `away_m`; nothing when
  // it did not yet.
  std::optional<double> came_back_s(double away_m, double near_m) const;
  // Mean distance of all places from the straight line between the first and the last.
  double mean_off_chord_m() const;
  // Mean rate at which its course turned, counter-clockwise, by the courses of the first and the last third of the
  // path. 0 when it did not move.
  double course_rate_rad_s() const;
  // The circle of least squares through all places: radius, and how well it fits. 0, 0 when there is none.
  struct Circle {
    double radius_m = 0;
    double off_m = 0;  // root mean square
  };
  Circle circle() const;

 private:
  struct Place {
    double at_s, x_m, y_m;
  };
  std::vector<Place> places_;
};

}  // namespace arkmesh::tracker
