// Obstacles and objects of an arena: where they are, who touches them, and how objects move when ODE has solved a step.
// Objects are rigid bodies with mass, which the table's friction holds; unlike robots they have momentum.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/arenas/solids.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "sim_ode/contact_solver.hpp"
#include "sim_ode/neighbour_grid.hpp"
#include "sim_ode/outline.hpp"
#include "sim_ode/shadows.hpp"

namespace arkmesh::sim_ode {

class SolidBodies {
 public:
  SolidBodies(double width_m, double height_m, const hal::Solids& solids,
              double robot_radius_m = hal::kilobot::body_radius_m);

  bool empty() const { return things_.empty(); }
  bool any_moves() const { return first_object_ < static_cast<int>(things_.size()); }
  // Objects for physics, in their order.
  std::vector<ObjectBody> objects() const;

  // Who may touch whom while nobody moves by more than half of `skin_m`. `robots` is built from x, y.
  void list_near(const NeighbourGrid& robots, std::span<const double> x, std::span<const double> y, double skin_m);

  // The step's contacts, into `solver`. Robots by ContactWorld::body.
  template <class BodyOf>
  void find_contacts(std::span<const double> x, std::span<const double> y, double reach_m, double step_s,
                     ContactSolver& solver, BodyOf&& body_of);
  // Moves objects as solved; returns how far any point of one went.
  double move(ContactSolver& solver, double step_s);
  // How deep the contacts of the step ended, deepest first; metres. x, y after the step.
  struct Depth {
    double deepest_m = 0;
    int deeper_than_1mm = 0;
  };
  Depth depth(ContactSolver& solver, std::span<const double> x, std::span<const double> y) const;

  // A tick begins: where poses() begins.
  void begin_tick();
  // `share` 0..1 of the way from the tick's beginning to now.
  void poses(double share, std::vector<hal::ObjectObservation>& out) const;
  // All of them as they lie now, in light's way; the rim of an arena without dents is not, as walls are not.
  void shade(Shadows& out) const;
  // What is wrong with where objects start, as the end of a sentence; they count from 0. Empty when nothing is.
  std::string misplaced() const;
  double robot_radius_m() const { return robot_radius_m_; }
  // How far a point is from the nearest of them, `at_most_m` at most; negative inside, and outside the rim.
  double clearance_m(double x, double y, double at_most_m) const;

 private:
  // Obstacles first, then objects. Where the centre of mass is, in the arena; `heading` turns the outline about it.
  struct Thing {
    Outline outline;
    bool moves;
    double x, y, heading, cos, sin;
    double vx = 0, vy = 0, spin = 0;  // m/s, rad/s
    double began_x = 0, began_y = 0, began_heading = 0;
    ObjectBody body{};
    hal::Point own_origin{};  // of the frame in which its pose is told, from the centre of mass
  };
  struct Near {
    int robot, thing;
  };
  struct NearThings {
    int object, other;  // other: -1 left, -2 right, -3 bottom, -4 top wall
  };
  // A contact that may have counted, for depth().
  struct Touched {
    int a_body, robot, object, other;
  };
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  PlacedOutline placed(const Thing& thing) const { return {&thing.outline, thing.x, thing.y, thing.cos, thing.sin}; }
  int body(int thing, ContactSolver& solver, double step_s);
  void find_object_contacts(double reach_m, double step_s, ContactSolver& solver);
  void wall_touches(const Thing& object, int wall, double reach_m, std::vector<Outline::Touch>& out) const;

  double width_m_, height_m_, robot_radius_m_;
  std::vector<Thing> things_;
  int first_object_ = 0, rim_begin_ = 0, rim_end_ = 0;  // things that shade() leaves out
  std::optional<Outline> floor_;                        // of an arena that is no rectangle
  std::vector<Near> near_;
  std::vector<NearThings> near_things_;
  std::vector<int> body_of_;  // by thing, in this step; -1
  std::vector<Touched> touched_;
  mutable std::vector<Outline::Touch> touches_;
};

template <class BodyOf>
void SolidBodies::find_contacts(std::span<const double> x, std::span<const double> y, double reach_m, double step_s,
                                ContactSolver& solver, BodyOf&& body_of) {
  body_of_.assign(things_.size(), -1);
  touched_.clear();
  // what slides goes on, touched or not
  for (int i = first_object_; i < static_cast<int>(things_.size()); ++i) {
    const Thing& thing = things_[index(i)];
    if (thing.vx != 0 || thing.vy != 0 || thing.spin != 0) body(i, solver, step_s);
  }
  for (const Near& near : near_) {
    const Thing& thing = things_[index(near.thing)];
    touches_.clear();
    placed(thing).touches(x[index(near.robot)], y[index(near.robot)], robot_radius_m_, reach_m, touches_);
    for (const Outline::Touch& touch : touches_) {
      const int a = body_of(near.robot), b = thing.moves ? body(near.thing, solver, step_s) : -1;
      const ContactBody& one = solver.bodies()[index(a)];
      // the touch's normal points to the robot, the contact's away from it
      const double closing = -(one.dx * touch.normal_x + one.dy * touch.normal_y);
      solver.add_solid(a, b, -touch.normal_x, -touch.normal_y, touch.gap_m, closing > touch.gap_m, -1);
      touched_.push_back({a, near.robot, -1, near.thing});
    }
  }
  find_object_contacts(reach_m, step_s, solver);
}

}  // namespace arkmesh::sim_ode
