// Where robots are and how they move, touch and push in the plane. Bodies are discs without momentum: at each step a
// robot sets out with the velocity its motors give it, and contacts share the motion out (friction with the arena
// outweighs inertia by far). Finds the contacts; ContactSolver makes them hold.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "hal/types.hpp"
#include "sim_ode/contact_solver.hpp"
#include "sim_ode/host/motors.hpp"
#include "sim_ode/neighbour_grid.hpp"
#include "sim_ode/solid_bodies.hpp"

namespace arkmesh::sim_ode {

class ContactWorld {
 public:
  // Arena frame; `start` are poses at rest. Seeds ODE's generator for each step from `seed` and the step's number.
  ContactWorld(double width_m, double height_m, const ContactSettings& contacts, std::uint64_t seed,
               const std::vector<hal::Pose>& start, const hal::Solids& solids = {});

  // In force until the next call.
  void set_velocity(int robot, const Velocity& velocity);
  // One robot tick, in so many steps that nobody goes far in one. A step is these three, in this order.
  void tick();
  void list_pairs();     // who may touch, when the old list has served its time
  void move_alone();     // everybody as if alone
  void hold_contacts();  // then those who touch
  // A hand moves a robot. Off the arena it stands where nobody can meet it.
  void place(int robot, const hal::Pose& pose);
  void take_off(int robot);
  bool in_arena(int robot) const { return in_arena_[index(robot)] != 0; }

  int robots() const { return static_cast<int>(now_.x.size()); }
  const std::vector<double>& x() const { return now_.x; }
  const std::vector<double>& y() const { return now_.y; }
  // Unit vector of a robot's heading.
  std::pair<double, double> heading(int robot) const { return {now_.cos[index(robot)], now_.sin[index(robot)]}; }
  // `share` 0..1 of the way from before the last tick to after it.
  hal::Pose pose(int robot, double share) const;
  // Metres that any robot has moved since the world began, at most.
  double longest_path_m() const { return longest_path_m_; }

  struct Totals {
    std::uint64_t steps = 0, contacts = 0;
    std::uint64_t ode_steps = 0, by_ode = 0, alone = 0;  // as ContactSolver has them
    std::uint64_t touching = 0;                          // robot-steps in contact
    std::uint64_t deep = 0;                              // contacts that ended a step more than 1 mm deep
    double deepest_m = 0;                                // penetration after a step
    double drift_m = 0;                                  // out of the plane, in a step
  };
  const Totals& totals() const { return totals_; }
  const SolidBodies& solids() const { return solids_; }

 private:
  // By robot. Headings are angles; cosine and sine follow them step by step and are brought in line from time to time.
  struct Places {
    std::vector<double> x, y, heading, cos, sin;
  };
  // Two robots, or a robot and the wall on one side (b: -1 left, -2 right, -3 bottom, -4 top), that may touch before
  // the next listing.
  struct Pair {
    int a, b;
    float push_m, rub_m;  // of the last step, where ContactSolver begins; 0 for those not in contact
  };

  static std::size_t index(int robot) { return static_cast<std::size_t>(robot); }
  void divide_tick();
  void align_headings();
  void find_pairs();
  void find_contacts();
  int body(int robot);
  std::pair<double, double> motion(int robot) const;
  void correct_touched();

  double width_m_, height_m_, body_radius_m_;
  NeighbourGrid grid_;
  SolidBodies solids_;
  ContactSolver solver_;
  Places now_, before_;  // the last step
  Places tick_began_;    // while a tick is several steps
  int steps_per_tick_ = 1;
  double reach_m_;  // nobody comes nearer to anybody in a step
  std::vector<Velocity> velocity_;
  std::vector<double> ahead_, left_;                // metres per step at mid-turn, robot frame
  std::vector<double> turn_, turn_cos_, turn_sin_;  // per step
  std::vector<std::uint8_t> in_arena_;
  std::uint64_t ticks_ = 0;
  double fastest2_ = 0;  // square of the longest step that motors made since headings were aligned
  std::vector<Pair> pairs_, walls_;
  std::vector<int> body_of_;  // by robot, in this step; -1
  double slack_m_ = 0;        // motion left until pairs_ must be listed anew
  double longest_path_m_ = 0;
  Totals totals_;
};

}  // namespace arkmesh::sim_ode
