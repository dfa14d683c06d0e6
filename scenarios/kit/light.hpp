// Virtual light: even, rising along a direction, and beams that wander, as a robot's sensor of ambient light would read
// it.
#pragma once

#include <vector>

#include "hal/types.hpp"
#include "lab/lab.hpp"

namespace arkmesh::scenarios::kit {

class Light {
 public:
  static constexpr double brightest = 1023;  // what kilo_get_ambientlight() reads at most: ten bits
  // A disc of light that goes along `path` and from its end to its beginning, at an even speed; one place: it stays.
  struct Beam {
    double level = brightest;
    double radius_m = 0.1;
    std::vector<hal::Point> path;
    double speed_m_s = 0;
  };
  struct Settings {
    double ambient = 0;
    hal::Point slope_per_m;  // what is added for each metre along x and y of the shared frame
    std::vector<Beam> beams;
  };
  // Throws std::invalid_argument with one sentence.
  explicit Light(Settings settings);

  // 0 to 1023, of all that shines on a place of the shared frame. Pure.
  double at(const hal::Point& in_shared, hal::LabTime now) const;
  // Where a beam's middle is.
  hal::Point middle(const Beam& beam, hal::LabTime now) const;
  // The beams, in an arena that sees the shared frame so.
  void draw(lab::Lab& lab, const hal::Projection& arena) const;

 private:
  Settings settings_;
};

}  // namespace arkmesh::scenarios::kit
