// Shares a step's motion out among bodies in contact, cluster by cluster, so that nobody goes beyond touching. Knows
// what is given to it for one step only. A contact alone is solved by its closed form; clusters go to ODE, or, as
// settings say, those of robots alone are solved in place, contact by contact until nothing moves any more.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim_ode/contacts.hpp"
#include "sim_ode/ode_contacts.hpp"

namespace arkmesh::sim_ode {

class ContactSolver {
 public:
  ContactSolver(const ContactSettings& settings, std::uint64_t seed, std::span<const ObjectBody> objects = {});

  // Forgets everything but memory.
  void clear();
  // `robot` as in ContactBody; where its centre of mass is, and how it wants to move. An object that moves is solved
  // whether it touches something or not.
  int add_body(int robot, double x_m, double y_m, double dx_m, double dy_m, double roll_m);
  // Between robots. `closes`: the gap is used up within the step even if nothing else happens. Other contacts count
  // only when something pushes one of their bodies.
  void add(int a, int b, double normal_x, double normal_y, double gap_m, bool closes, double push_m, double rub_m,
           int source);
  // A robot and a wall of the arena.
  void add_wall(int a, double normal_x, double normal_y, double gap_m, bool closes, double push_m, double rub_m,
                int source);
  // A robot and an obstacle (b: -1) or an object.
  void add_solid(int a, int b, double normal_x, double normal_y, double gap_m, bool closes, int source);
  // An object and a wall or an obstacle (b: -1), or another object, which touch at a point.
  void add_object(int a, int b, double normal_x, double normal_y, double gap_m, ContactPoint at);
  // Bodies and contacts without anything that closes stay as they are.
  void solve(double step_s);

  bool empty() const { return contacts_.empty() && sliding_.empty(); }
  const std::vector<ContactBody>& bodies() const { return bodies_; }
  // Whether something may have changed a body's motion.
  bool in_contact(int body) { return clusters_[index(root(body))].closes; }
  // The contacts that counted, by cluster.
  std::span<const Contact> solved() const { return ordered_; }
  // What solve() was given so far: calls of ODE's step, contacts that ODE solved, and contacts that touched no other
  // one and were solved in closed form. The rest was solved in place (Solver::fast).
  std::uint64_t ode_steps() const { return ode_.steps(); }
  std::uint64_t solved_by_ode() const { return solved_by_ode_; }
  std::uint64_t alone() const { return alone_; }
  // How far any body has come out of the plane in one step.
  double drift_m() const { return ode_.drift_m(); }

 private:
  enum class Company : std::uint8_t { robots, obstacles, objects };
  // Who solves a cluster.
  enum Way : std::uint8_t { here, by_ode, by_ode_with_objects, ways };
  struct Cluster {
    int parent;    // a body of the same cluster; itself at its root, where the rest holds
    int contacts;  // then, negative: has its place
    int at;
    bool closes;
    Company company;  // the hardest of all that take part
  };

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  int root(int body);
  void join(int a, int b, bool closes, Company company);
  int add_fixed();
  Way way(const Cluster& cluster) const;
  void order_by_cluster();
  double relax(Contact& contact);
  void apply(const Contact& contact, double push_m, double rub_m);
  void solve_here(std::span<Contact> cluster);

  Solver solver_;
  int rounds_;  // of ODE's
  double friction_;
  std::vector<ContactBody> bodies_;
  std::vector<ContactPoint> places_;  // of the bodies' centres of mass, before the step
  std::vector<Cluster> clusters_;     // by body
  std::vector<Contact> contacts_, ordered_;
  std::size_t end_of_[ways] = {};     // in ordered_
  std::vector<ContactPoint> points_;  // of contacts of objects
  std::vector<int> sliding_;          // objects on their way
  std::uint64_t alone_ = 0, solved_by_ode_ = 0;
  int now_ = 0;  // counts within solve_here
  OdeContacts ode_;
};

}  // namespace arkmesh::sim_ode
