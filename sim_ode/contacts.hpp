// What takes part in a step's contacts: bodies that want to move, contacts that hold them up, and how contacts hold.
#pragma once

#include <cstdint>

#include "hal/platforms/kilobot/body.hpp"

namespace arkmesh::sim_ode {

enum class Solver : std::uint8_t {
  ode,  // ODE solves every cluster of contacts
  fast  // clusters of robots alone are solved in place; ODE solves crowds, and all that has to do with obstacles,
        // objects
};

struct ContactSettings {
  Solver solver = Solver::ode;
  int ode_rounds = 10;    // of ODE's quick step: contacts of crowds stay within 0.3 mm
  double friction = 0.3;  // coefficient of Coulomb's, between bodies and with walls
  // The force with which a robot that drives at `speed_m_s` pushes something that does not give way: what its vibrating
  // legs hold on to the table, about a quarter of its weight of 16 g. An assumption: no source gives it.
  double push_n = 0.04;
  double speed_m_s = 0.01;
  double body_radius_m = hal::kilobot::body_radius_m;  // of robots
};

// What one body wants to do in this step and, after the contacts were solved, does. Arena frame, metres.
struct ContactBody {
  double dx, dy;
  double roll;   // its turn, as the path of a point at a robot's radius; counter-clockwise
  int robot;     // -1: a piece of wall or an obstacle, which nothing moves; -2, -3, ...: object 0, 1, ...
  int moved_at;  // the solver's
};

// A place in the arena frame, metres.
struct ContactPoint {
  double x, y;
};

// Two bodies, or a body and something that never moves. The unit normal points from the first to the second.
struct Contact {
  int a, b;
  double normal_x, normal_y;
  double gap_m;  // before the step; negative: how deep
  double push_m,
      rub_m;    // taken from the motion along the normal and across it: the last step's before solve(), then this one's
  float share;  // of a correction that each side takes: 1/2, or 1 where the second never moves
  int seen_at;  // by solve()
  int source;   // the caller's
  bool of_solid = false;  // with an obstacle or an object, or between such
  bool fixed() const { return share == 1; }
};

// Share of a penetration that is undone in a step.
inline constexpr double push_out = 0.5;

// What may be closed of a gap in a step; negative: what must be undone.
inline double allowed_m(double gap_m) {
  return gap_m > 0 ? gap_m : push_out * gap_m;
}

}  // namespace arkmesh::sim_ode
