#include "sim_ode/contact_solver.hpp"

#include <doctest/doctest.h>

#include <vector>

namespace {

using arkmesh::sim_ode::ContactSolver;

constexpr double diameter_m = 0.033, way_m = 0.0003;

// A row of robots along x that touch; the first one pushes. `warm_m`: what each contact is said to have pushed a step
// ago.
std::vector<double> pushed_row(int robots, bool wall_at_end, double warm_m) {
  ContactSolver solver(0.3, 1);
  std::vector<double> x, y(static_cast<std::size_t>(robots), 0);
  for (int i = 0; i < robots; ++i) {
    x.push_back(diameter_m * i);
    solver.add_body(i, i == 0 ? way_m : 0, 0, 0);
  }
  for (int i = 0; i + 1 < robots; ++i) solver.add(i, i + 1, 1, 0, 0, i == 0, warm_m, 0, i);
  if (wall_at_end) solver.add_wall(robots - 1, 1, 0, 0, false, warm_m, 0, robots);
  solver.solve(0, x, y);
  std::vector<double> went;
  for (int i = 0; i < robots; ++i) went.push_back(solver.bodies()[static_cast<std::size_t>(i)].dx);
  return went;
}

}  // namespace

TEST_CASE("pushed robots share the pusher's motion, whatever the last step's pushes were") {
  // One that pushes k others moves at 1/(k+1) of its speed, and so do they; the last step's pushes say only where the
  // search begins.
  for (double warm_m : {0.0, 0.0001, 0.001})
    for (int robots : {2, 3, 5}) {
      CAPTURE(warm_m);
      CAPTURE(robots);
      for (double went : pushed_row(robots, false, warm_m))
        CHECK(went == doctest::Approx(way_m / robots).epsilon(0.25));
    }
}

TEST_CASE("nobody is pushed through a wall") {
  // Four in a row against a wall: all the motion is taken away, but for the ten micrometres for each contact that count
  // as solved.
  for (double warm_m : {0.0, 0.0001})
    for (double went : pushed_row(4, true, warm_m)) {
      CHECK(went < 4e-5);
      CHECK(went > -4e-5);
    }
}

TEST_CASE("contacts that nothing closes change nothing") {
  // Two robots side by side, one standing, one leaving; a push of the last step must not hold them back.
  ContactSolver solver(0.3, 1);
  solver.add_body(0, -way_m, 0, 0);
  solver.add_body(1, 0, 0, 0);
  solver.add(0, 1, 1, 0, 0, false, 0.001, 0.0001, 0);
  const std::vector<double> x = {0, diameter_m}, y = {0, 0};
  solver.solve(0, x, y);
  CHECK(solver.solved().empty());
  CHECK_FALSE(solver.in_contact(0));
  CHECK(solver.bodies()[0].dx == -way_m);
  CHECK(solver.bodies()[1].dx == 0);
}
