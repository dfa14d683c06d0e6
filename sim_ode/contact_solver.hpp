// Shares a step's motion out among bodies in contact, cluster by cluster, so that nobody goes beyond touching. Knows
// what is given to it for one step only. Small clusters are solved here, contact by contact until nothing moves any
// more; crowds are lent to ODE.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace arkmesh::sim_ode {

class ContactSolver {
 public:
  // What one body wants to do in this step and, after solve(), does. Metres; `roll` is how far its rim turns,
  // counter-clockwise.
  struct Body {
    double dx, dy, roll;
    int robot;
    int moved_at;  // by solve(): when it last moved by more than counts
  };
  // Two bodies, or a body and something that never moves. The unit normal points from the first to the second.
  struct Contact {
    int a, b;
    double normal_x, normal_y;
    double gap_m;  // before the step; negative: how deep
    double push_m,
        rub_m;  // taken from the motion along the normal and across it: the last step's before solve(), then this one's
    double share;  // of a correction that each side takes: 1/2, or 1 for a wall
    int seen_at;   // by solve()
    int source;    // the caller's
    bool wall() const { return share == 1; }
  };

  // ODE's generator is seeded for each step from `seed` and the step's number.
  ContactSolver(double friction, std::uint64_t seed);
  ~ContactSolver();

  // Forgets everything but memory.
  void clear();
  int add_body(int robot, double dx_m, double dy_m, double roll_m);
  // `closes`: the gap is used up within the step even if nothing else happens. Other contacts count only when something
  // pushes one of their bodies.
  void add(int a, int b, double normal_x, double normal_y, double gap_m, bool closes, double push_m, double rub_m,
           int source);
  void add_wall(int a, double normal_x, double normal_y, double gap_m, bool closes, double push_m, double rub_m,
                int source);
  // x and y of robots before the step. Bodies and contacts without anything that closes stay as they are.
  void solve(std::uint64_t step, std::span<const double> x, std::span<const double> y);

  bool empty() const { return contacts_.empty(); }
  const std::vector<Body>& bodies() const { return bodies_; }
  // Whether something may have changed a body's motion.
  bool in_contact(int body) { return clusters_[index(root(body))].closes; }
  // The contacts that counted, by cluster.
  std::span<const Contact> solved() const { return ordered_; }
  std::uint64_t ode_steps() const { return ode_steps_; }
  // How far any body has come out of the plane in one step.
  double drift_m() const { return drift_m_; }

 private:
  struct Cluster {
    int parent;    // a body of the same cluster; itself at its root, where the rest holds
    int contacts;  // then, negative: has its place
    int at;
    bool closes;
  };
  struct Ode;

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  int root(int body);
  std::size_t order_by_cluster();
  double relax(Contact& contact);
  void apply(const Contact& contact, double push_m, double rub_m);
  void solve_small(std::span<Contact> cluster);
  void solve_with_ode(std::span<Contact> contacts, std::uint64_t step, std::span<const double> x,
                      std::span<const double> y);

  double friction_;
  std::uint64_t seed_;
  std::vector<Body> bodies_;
  std::vector<Cluster> clusters_;  // by body
  std::vector<Contact> contacts_, ordered_;
  int now_ = 0;  // counts within solve_small
  std::uint64_t ode_steps_ = 0;
  double drift_m_ = 0;
  std::unique_ptr<Ode> ode_;
};

}  // namespace arkmesh::sim_ode
