// A part of the plane that robots are in or not: a disc or a polygon. And a value that changes at set times, such as a
// region's quality.
#pragma once

#include <string>
#include <vector>

#include "hal/overlay/colour.hpp"
#include "hal/types.hpp"
#include "lab/lab.hpp"

namespace arkmesh::scenarios::kit {

class Region {
 public:
  // Metres, in a frame of the caller's. Both throw std::invalid_argument with one sentence: for a radius that is no
  // positive number; for fewer than three corners, corners that are no places, sides that cross, or no area.
  static Region disc(const hal::Point& centre, double radius_m);
  static Region polygon(std::vector<hal::Point> corners);

  // Its edge belongs to a disc; of a polygon's edge the part that is left or below does.
  bool contains(const hal::Point& place) const;
  double area_m2() const;
  // A region of the shared frame as an arena sees it.
  Region seen_in(const hal::Projection& arena) const;
  // Of a lab whose arena is the region's frame.
  void draw(lab::Lab& lab, hal::Colour colour, bool filled = false, const std::string& label = {}) const;

 private:
  hal::Shape shape_;  // a disc's centre is centre_; corners stand in the region's frame
  hal::Point centre_;
};

// A value from each of some times on.
class Schedule {
 public:
  struct Change {
    double from_s, value;
  };
  // Throws std::invalid_argument when there is none, or the times do not ascend.
  explicit Schedule(std::vector<Change> changes);
  // The first value holds before its time, too.
  double at(double time_s) const;

 private:
  std::vector<Change> changes_;
};

}  // namespace arkmesh::scenarios::kit
