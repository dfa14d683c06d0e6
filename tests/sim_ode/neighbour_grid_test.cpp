#include "sim_ode/neighbour_grid.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "hal/random.hpp"

namespace {

using arkmesh::sim_ode::NeighbourGrid;

struct Points {
  std::vector<double> x, y;
  double apart(std::size_t a, std::size_t b) const { return std::hypot(x[a] - x[b], y[a] - y[b]); }
};

// Some of them lie outside the arena, as robots taken off a testbed do.
Points scattered(std::size_t count, double width_m, double height_m) {
  arkmesh::hal::RandomStream chance(count, "points");
  Points out;
  for (std::size_t i = 0; i < count; ++i) {
    const double stretch = i % 10 == 0 ? 1.2 : 1;
    out.x.push_back(stretch * chance.uniform(-width_m / 2, width_m / 2));
    out.y.push_back(stretch * chance.uniform(-height_m / 2, height_m / 2));
  }
  return out;
}

}  // namespace

TEST_CASE("a grid finds each pair once and every neighbour") {
  // Compares with all pairs by hand, in arenas crowded, long and nearly empty; only distances within rounding may go
  // either way.
  struct Case {
    std::size_t points;
    double width_m, height_m, reach_m;
  };
  for (const Case& c : {Case{300, 1, 1, 0.053}, Case{200, 10, 0.1, 0.1}, Case{50, 100, 100, 3}, Case{1, 1, 1, 0.1},
                        Case{0, 1, 1, 0.1}}) {
    CAPTURE(c.points);
    CAPTURE(c.width_m);
    const Points points = scattered(c.points, c.width_m, c.height_m);
    NeighbourGrid grid(c.width_m, c.height_m, c.reach_m, static_cast<int>(c.points));
    grid.build(points.x, points.y);
    const double rounded_m = 4 * NeighbourGrid::rounded_m;

    std::set<std::pair<int, int>> found;
    grid.visit_pairs(c.reach_m, [&](int a, int b) {
      CHECK(found.insert(std::minmax(a, b)).second);
      CHECK(points.apart(static_cast<std::size_t>(a), static_cast<std::size_t>(b)) < c.reach_m + rounded_m);
    });
    std::vector<int> room;
    for (std::size_t a = 0; a < c.points; ++a) {
      const auto near = grid.gather(points.x[a], points.y[a], c.reach_m, room);
      for (std::size_t b = 0; b < c.points; ++b) {
        const double apart = points.apart(a, b);
        const bool gathered = std::find(near.begin(), near.end(), static_cast<int>(b)) != near.end();
        if (apart <= c.reach_m) CHECK(gathered);
        if (apart > c.reach_m + rounded_m) CHECK_FALSE(gathered);
        if (a < b && apart < c.reach_m - rounded_m) CHECK(found.contains({static_cast<int>(a), static_cast<int>(b)}));
      }
    }
  }
}
