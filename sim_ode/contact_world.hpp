// Where robots are and how they move, touch and push in the plane. Free robots and small clusters in contact are dealt with
// here; larger clusters are handed to ODE for one step. Bodies are discs without momentum: at each step a robot sets out with the velocity
// its motors give it, and contacts share the motion out (friction with the table outweighs inertia by far).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "hal/types.hpp"
#include "sim_ode/motors.hpp"
#include "sim_ode/neighbour_grid.hpp"

namespace arkmesh::sim_ode {

class ContactWorld {
 public:
  // Arena frame; `start` are poses at rest. Seeds ODE's generator for each step from `seed` and the step's number.
  ContactWorld(double width_m, double height_m, double friction, std::uint64_t seed, const std::vector<hal::Pose>& start);
  ~ContactWorld();

  // In force until the next call.
  void set_velocity(int robot, const Velocity& velocity);
  // One robot tick.
  void step();
  // A hand moves a robot. Off the table it stands where nobody can meet it.
  void place(int robot, const hal::Pose& pose);
  void take_off(int robot);
  bool on_table(int robot) const { return on_table_[index(robot)] != 0; }

  int robots() const { return static_cast<int>(x_.size()); }
  const std::vector<double>& x() const { return x_; }
  const std::vector<double>& y() const { return y_; }
  // Unit vector of a robot's heading.
  std::pair<double, double> heading(int robot) const { return {cos_[index(robot)], sin_[index(robot)]}; }
  // `share` 0..1 of the way from before the last step to after it.
  hal::Pose pose(int robot, double share) const;
  // Grows by less than this bound in each step: metres that any robot has moved since the world began.
  double longest_path_m() const { return longest_path_m_; }

  struct Totals {
    std::uint64_t steps = 0, contacts = 0, ode_steps = 0;
    std::uint64_t touching = 0;       // robot-steps in contact
    std::uint64_t deep = 0;           // contacts that ended a step more than 1 mm deep
    double deepest_m = 0;             // penetration after a step
  };
  const Totals& totals() const { return totals_; }

 private:
  // Robot a against robot b, or against a wall (b < 0). The normal points from a to b.
  struct Contact {
    int a, b;
    double normal_x, normal_y;
    double gap_m;
    bool certain;   // closes within this step if nothing else happens
    int cluster;    // its robot with the smallest number
    double push, rub;  // shares of this step's motion taken away along the normal and across it
  };
  struct Ode;

  static std::size_t index(int robot) { return static_cast<std::size_t>(robot); }
  void find_pairs();
  void find_contacts();
  void spread_contacts();
  void make_clusters();
  double relax(Contact& contact);
  void solve_small(std::span<Contact* const> cluster);
  void solve_with_ode(std::span<Contact* const> contacts);
  void measure_penetration();
  int root(int robot);

  double width_m_, height_m_, friction_;
  std::uint64_t seed_;
  NeighbourGrid grid_;
  std::vector<double> x_, y_, cos_, sin_;              // now
  std::vector<double> x0_, y0_, cos0_, sin0_;          // one step ago
  std::vector<double> ahead_, left_;                   // metres per step at mid-turn, robot frame
  std::vector<double> turn_cos_, turn_sin_, turn_;     // per step
  std::vector<double> dx_, dy_, dturn_;                // this step's motion, arena frame
  std::vector<std::uint8_t> touched_;                  // this step
  std::vector<std::uint8_t> on_table_;
  std::vector<std::pair<int, int>> pairs_;             // that may touch before the next rebuild
  double slack_m_ = 0;                                 // motion left until pairs_ must be rebuilt
  double longest_path_m_ = 0;
  std::vector<Contact> contacts_, maybe_;
  std::vector<Contact*> joined_, ordered_;             // that hold in this step; the same by cluster
  std::vector<int> parent_, cluster_size_, cluster_at_;
  Totals totals_;
  std::unique_ptr<Ode> ode_;
};

}  // namespace arkmesh::sim_ode
