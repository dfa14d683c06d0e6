// A step's contacts as ODE solves them: rigid bodies with mass, Coulomb friction between them, and the bounded friction
// with the table that holds objects. A world without gravity, whose bodies are lent to the robots that need one in a
// step. Positions stay the caller's; ODE gives motions.
#pragma once

#include <ode/ode.h>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "sim_ode/contacts.hpp"

namespace arkmesh::sim_ode {

// An object that robots push, as physics sees it.
struct ObjectBody {
  double mass_kg, inertia_kg_m2;  // about its centre of mass, in the plane
  double table_friction_n;        // what the table holds it with at most, in each direction
  double table_friction_n_m;      // and against turning
};

class OdeContacts {
 public:
  // A robot's wish to move is a motion that it gives up within a step (it has no momentum), so that its mass here is
  // what makes it push with ContactSettings::push_n. ODE's generator is seeded for each call from `seed` and the number
  // of earlier calls.
  OdeContacts(const ContactSettings& settings, std::uint64_t seed, std::span<const ObjectBody> objects);
  ~OdeContacts();
  OdeContacts(const OdeContacts&) = delete;
  OdeContacts& operator=(const OdeContacts&) = delete;

  // Changes the motions of the bodies in contact, and of `sliding`, objects on their way that touch nothing. `points`
  // is where bodies touch, of contacts whose first body is an object, found by Contact::source; `places` the bodies'
  // centres of mass.
  void solve(std::span<Contact> contacts, std::span<const int> sliding, std::span<const ContactPoint> points,
             std::span<const ContactPoint> places, std::vector<ContactBody>& bodies, int iterations, double step_s);
  std::uint64_t steps() const { return steps_; }
  // How far any body has come out of the plane in one step.
  double drift_m() const { return drift_m_; }

 private:
  struct Object {
    dBodyID body;
    dJointID slide, turn;           // the table's friction
    double push_x = 0, push_y = 0;  // where it is pushed to in this step
  };
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  dBodyID pooled(std::size_t i);
  void lend(int ours, const ContactBody& body, const ContactPoint& place, double step_s);
  void set_mass(dBodyID body, double mass_kg, double inertia_kg_m2);
  static void turn_friction(const Object& object);
  void attach(const Contact& contact, const ContactPoint& point, std::span<const ContactBody> bodies, double step_s);

  double friction_, robot_radius_m_, robot_kg_s_;  // the last: the mass of a robot for a step of 1 s
  std::uint64_t seed_;
  dWorldID world_;
  dJointGroupID contacts_;
  std::vector<dBodyID> pool_;  // for robots
  double pool_kg_ = 1;
  std::vector<Object> objects_;
  struct Loan {
    int ours;
    dBodyID body;
  };
  std::vector<Loan> loans_;
  std::vector<int> loan_of_;  // by our body, -1
  std::size_t robots_lent_ = 0;
  std::uint64_t steps_ = 0;
  double drift_m_ = 0;
};

}  // namespace arkmesh::sim_ode
