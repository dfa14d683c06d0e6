#include "sim_ode/contact_solver.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "hal/random.hpp"
#include "hal/types.hpp"
#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double diameter_m = 0.033, way_m = 0.0003, step_s = tick_us * 1e-6;
constexpr Solver both[] = {Solver::ode, Solver::fast};

// A row of robots along x that touch; the first one pushes. `warm_m`: what each contact is said to have pushed a step
// ago.
std::vector<double> pushed_row(Solver kind, int robots, bool wall_at_end, double warm_m) {
  ContactSolver solver({.solver = kind}, 1);
  for (int i = 0; i < robots; ++i) solver.add_body(i, diameter_m * i, 0, i == 0 ? way_m : 0, 0, 0);
  for (int i = 0; i + 1 < robots; ++i) solver.add(i, i + 1, 1, 0, 0, i == 0, warm_m, 0, i);
  if (wall_at_end) solver.add_wall(robots - 1, 1, 0, 0, false, warm_m, 0, robots);
  solver.solve(step_s);
  std::vector<double> went;
  for (int i = 0; i < robots; ++i) went.push_back(solver.bodies()[static_cast<std::size_t>(i)].dx);
  return went;
}

// Robots that touch or nearly do, each with a wish of its own; one of them at least runs into another.
struct RandomCluster {
  std::vector<hal::Pose> places;  // headings mean nothing
  std::vector<std::pair<double, double>> wishes;

  RandomCluster(int robots, hal::RandomStream& chance) {
    while (static_cast<int>(places.size()) < robots) {
      hal::Pose place;
      if (!places.empty()) {
        const hal::Pose& beside = places[chance.below(places.size())];
        const double angle = chance.uniform(0, 2 * std::numbers::pi),
                     apart = diameter_m + chance.uniform(-0.00002, 0.0003);
        place = {beside.x_m + apart * std::cos(angle), beside.y_m + apart * std::sin(angle), 0};
      }
      const auto overlaps = [&place](const hal::Pose& other) {
        return std::hypot(other.x_m - place.x_m, other.y_m - place.y_m) < diameter_m - 0.00002;
      };
      if (std::ranges::any_of(places, overlaps)) continue;
      const double to = chance.uniform(0, 2 * std::numbers::pi), way = chance.uniform() < 0.3 ? 0 : way_m;
      places.push_back(place);
      wishes.push_back({way * std::cos(to), way * std::sin(to)});
    }
  }

  std::vector<ContactBody> solve(const ContactSettings& settings) const {
    ContactSolver solver(settings, 1);
    for (std::size_t i = 0; i < places.size(); ++i)
      solver.add_body(static_cast<int>(i), places[i].x_m, places[i].y_m, wishes[i].first, wishes[i].second, 0);
    for (std::size_t i = 0; i < places.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const double x = places[i].x_m - places[j].x_m, y = places[i].y_m - places[j].y_m, d = std::hypot(x, y);
        if (d > diameter_m + 0.0015) continue;
        const double closing =
            ((wishes[j].first - wishes[i].first) * x + (wishes[j].second - wishes[i].second) * y) / d;
        solver.add(static_cast<int>(j), static_cast<int>(i), x / d, y / d, d - diameter_m, closing > d - diameter_m, 0,
                   0, 0);
      }
    solver.solve(step_s);
    return solver.bodies();
  }
};

}  // namespace

TEST_CASE("the fast solver gives what ODE gives") {
  // In clusters of 2 to 40 robots 99 % of them go where ODE with many rounds lets them go, to within 1 % of a free
  // step.
  hal::RandomStream chance(1, "clusters");
  int robots = 0, off = 0;
  double furthest = 0;
  for (int k = 0; k < 1000; ++k) {
    const RandomCluster cluster(2 + k % 39, chance);
    const auto fast = cluster.solve({.solver = Solver::fast}), ode = cluster.solve({.ode_rounds = 100});
    for (std::size_t i = 0; i < fast.size(); ++i) {
      const double apart = std::hypot(fast[i].dx - ode[i].dx, fast[i].dy - ode[i].dy);
      ++robots;
      off += apart > way_m / 100;
      furthest = std::max(furthest, apart);
    }
  }
  MESSAGE(off << " of " << robots << " off, furthest " << furthest / way_m << " of a free step");
  CHECK(off <= robots / 100);
}

TEST_CASE("a contact that touches no other one goes as ODE lets it go") {
  // The closed form beside ODE's step with 300 rounds: two robots, or a robot and a wall, of any gap, direction, motion
  // and turn. Equal at a wall and where robots just touch; otherwise ODE's point of contact, on the first robot's rim,
  // is not on the second one's.
  hal::RandomStream chance(2, "alone");
  double furthest = 0, furthest_touching = 0;
  int closing = 0;
  for (int k = 0; k < 2000; ++k) {
    const double angle = chance.uniform(0, 2 * std::numbers::pi), nx = std::cos(angle), ny = std::sin(angle),
                 gap_m = k % 4 == 0 ? 0 : chance.uniform(-way_m / 2, way_m);
    const bool wall = k % 2 == 1;
    const ContactSettings settings{.friction = k % 3 == 0 ? 0 : chance.uniform(0, 1)};
    ContactSolver alone(settings, 1);
    OdeContacts ode(settings, 1, {});
    std::vector<ContactBody> bodies;
    std::vector<ContactPoint> places;
    for (int i = 0; i < 2; ++i) {
      ContactBody body{chance.uniform(-way_m, way_m), chance.uniform(-way_m, way_m), chance.uniform(-way_m, way_m), i,
                       0};
      if (wall && i == 1) body = {0, 0, 0, -1, 0};
      const double x_m = i * (diameter_m + gap_m) * nx, y_m = i * (diameter_m + gap_m) * ny;
      if (body.robot >= 0) alone.add_body(i, x_m, y_m, body.dx, body.dy, body.roll);
      bodies.push_back(body);
      places.push_back({x_m, y_m});
    }
    const bool closes = (bodies[0].dx - bodies[1].dx) * nx + (bodies[0].dy - bodies[1].dy) * ny > gap_m;
    if (wall)
      alone.add_wall(0, nx, ny, gap_m, closes, 0, 0, -1);
    else
      alone.add(0, 1, nx, ny, gap_m, closes, 0, 0, 0);
    alone.solve(step_s);
    if (!closes) continue;
    ++closing;
    Contact contact{0, 1, nx, ny, gap_m, 0, 0, wall ? 1.0F : 0.5F, 0, 0};
    ode.solve({&contact, 1}, {}, {}, places, bodies, 300, step_s);
    for (std::size_t i = 0; i < (wall ? 1U : 2U); ++i) {
      const ContactBody& one = alone.bodies()[i];
      const double apart =
          std::max(std::hypot(one.dx - bodies[i].dx, one.dy - bodies[i].dy), std::abs(one.roll - bodies[i].roll));
      furthest = std::max(furthest, apart);
      if (wall || gap_m == 0) furthest_touching = std::max(furthest_touching, apart);
    }
  }
  MESSAGE(closing << " contacts, furthest " << furthest / way_m << " of a free step");
  CHECK(closing > 400);
  CHECK(furthest_touching < way_m * 1e-6);
  CHECK(furthest < way_m / 100);
}

TEST_CASE("pushed robots share the pusher's motion, whatever the last step's pushes were") {
  // One that pushes k others moves at 1/(k+1) of its speed, and so do they; the last step's pushes say only where the
  // search begins.
  for (const Solver kind : both)
    for (double warm_m : {0.0, 0.0001, 0.001})
      for (int robots : {2, 3, 5}) {
        CAPTURE(warm_m);
        CAPTURE(robots);
        for (double went : pushed_row(kind, robots, false, warm_m))
          CHECK(went == doctest::Approx(way_m / robots).epsilon(0.05));
      }
}

TEST_CASE("nobody is pushed through a wall") {
  // Four in a row against a wall: all the motion is taken away, but for the micrometres for each contact that count
  // as solved.
  for (const Solver kind : both)
    for (double warm_m : {0.0, 0.0001})
      for (double went : pushed_row(kind, 4, true, warm_m)) {
        CHECK(went < 4e-5);
        CHECK(went > -4e-5);
      }
}

TEST_CASE("contacts that nothing closes change nothing") {
  // Two robots side by side, one standing, one leaving; a push of the last step must not hold them back.
  for (const Solver kind : both) {
    ContactSolver solver({.solver = kind}, 1);
    solver.add_body(0, 0, 0, -way_m, 0, 0);
    solver.add_body(1, diameter_m, 0, 0, 0, 0);
    solver.add(0, 1, 1, 0, 0, false, 0.001, 0.0001, 0);
    solver.solve(step_s);
    CHECK(solver.solved().empty());
    CHECK_FALSE(solver.in_contact(0));
    CHECK(solver.bodies()[0].dx == -way_m);
    CHECK(solver.bodies()[1].dx == 0);
  }
}

}  // namespace arkmesh::sim_ode
