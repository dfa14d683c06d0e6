// A disc or a polygon in the plane, and where others touch it. Polygons may have dents.
#pragma once

#include <vector>

#include "hal/types.hpp"

namespace arkmesh::sim_ode {

class Outline {
 public:
  explicit Outline(hal::Shape shape);

  // Where something outside may touch.
  struct Touch {
    double gap_m;               // negative: how deep it is inside
    double normal_x, normal_y;  // outwards
    double x, y;                // the point of the outline
  };
  // Appends where a disc around x, y is less than `reach_m` away, or inside: one place, or one for each side in a dent.
  // Its own frame, metres; a disc of radius 0 is a point.
  void touches(double x, double y, double radius_m, double reach_m, std::vector<Touch>& out) const;
  // From a point to the outline; negative inside.
  double distance_m(double x, double y) const;

  const hal::Shape& shape() const { return shape_; }
  bool is_convex() const { return convex_; }
  bool is_disc() const { return shape_.corners.empty(); }
  // Nothing of it is further from its origin.
  double bound_m() const { return bound_m_; }
  // Where its mass is, if evenly spread; the square of its radius of gyration there, and the mean distance from there.
  const hal::Point& centre() const { return centre_; }
  double gyration_m2() const { return gyration_m2_; }
  double mean_distance_m() const { return mean_distance_m_; }

 private:
  bool inside(double x, double y) const;
  void measure();

  hal::Shape shape_;
  struct Side {
    double x, y;              // where it begins
    double ahead_x, ahead_y;  // unit vector along it
    double length_m;
  };
  std::vector<Side> sides_;  // counter-clockwise: outwards is right of ahead
  double bound_m_ = 0, gyration_m2_ = 0, mean_distance_m_ = 0;
  hal::Point centre_;
  bool convex_ = true;
};

// An outline somewhere in the arena.
struct PlacedOutline {
  const Outline* outline;
  double x, y, cos, sin;

  // As Outline's, in the arena's frame.
  void touches(double at_x, double at_y, double radius_m, double reach_m, std::vector<Outline::Touch>& out) const;
  double distance_m(double at_x, double at_y) const;
  hal::Point corner(std::size_t i) const;
  std::size_t corners() const { return outline->shape().corners.size(); }
};

PlacedOutline place(const Outline& outline, const hal::Pose& pose);

// Appends where two outlines are less than `reach_m` apart; normals point out of the second one.
void touches_of(const PlacedOutline& one, const PlacedOutline& other, double reach_m, std::vector<Outline::Touch>& out);

}  // namespace arkmesh::sim_ode
