// Drawing sites and types.
#include "scenarios/dhtf/sites.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <set>

using namespace arkmesh;
using namespace arkmesh::scenarios::dhtf;

TEST_CASE("dhtf sites: cells of the owner's arena in the shared frame") {
  // Cell 0 is the north-west corner, numbers go east and then south, and the owner's projection is applied.
  const hal::Projection same;
  CHECK(cell_in_shared(0, 1, 1, same).x_m == doctest::Approx(-0.375));
  CHECK(cell_in_shared(0, 1, 1, same).y_m == doctest::Approx(0.375));
  CHECK(cell_in_shared(3, 1, 1, same).x_m == doctest::Approx(0.375));
  CHECK(cell_in_shared(14, 1, 1, same).x_m == doctest::Approx(0.125));
  CHECK(cell_in_shared(14, 1, 1, same).y_m == doctest::Approx(-0.375));
  CHECK(cell_in_shared(5, 2, 1, same).x_m == doctest::Approx(-0.25));
  // Half the arena at twice the scale is the same place; a shifted projection shifts it.
  const hal::Projection doubled{.shift_x_m = 10, .scale = 2};
  CHECK(cell_in_shared(14, 0.5, 0.5, doubled).x_m == doctest::Approx(10.125));
  CHECK(cell_in_shared(14, 0.5, 0.5, doubled).y_m == doctest::Approx(-0.375));
}

TEST_CASE("dhtf sites: which cells are drawn") {
  // M different cells, ascending; all 16 occur, or the 12 that are no corners; the draw depends on the seed.
  for (bool corners : {true, false}) {
    Settings settings;
    settings.corners = corners;
    std::set<int> seen;
    std::set<std::vector<int>> draws;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      hal::RandomStream random(seed, "shark/sites");
      const std::vector<int> cells = draw_cells(settings, random);
      CHECK(cells.size() == 8);
      CHECK(std::is_sorted(cells.begin(), cells.end()));
      CHECK(std::adjacent_find(cells.begin(), cells.end()) == cells.end());
      seen.insert(cells.begin(), cells.end());
      draws.insert(cells);
    }
    CHECK(seen.size() == (corners ? 16u : 12u));
    for (int corner : {0, 3, 12, 15}) CHECK(seen.contains(corner) == corners);
    CHECK(draws.size() > 100);
  }
}

TEST_CASE("dhtf sites: types") {
  // "easy" and "hard" are pure, "half" has exactly half, "random" is a fair coin for each site.
  Settings settings;
  const auto count = [&](Types types, std::uint64_t seed) {
    settings.types = types;
    hal::RandomStream random(seed, "shark/sites");
    const std::vector<int> hard = draw_hard(settings, random);
    CHECK(hard.size() == 8);
    return std::accumulate(hard.begin(), hard.end(), 0);
  };
  int sum = 0;
  std::set<int> random_counts;
  std::set<std::vector<int>> halves;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    CHECK(count(Types::easy, seed) == 0);
    CHECK(count(Types::hard, seed) == 8);
    CHECK(count(Types::half, seed) == 4);
    hal::RandomStream random(seed, "shark/sites");
    halves.insert(draw_hard(settings, random));
    const int hard = count(Types::random, seed);
    sum += hard;
    random_counts.insert(hard);
  }
  CHECK(sum == doctest::Approx(2000).epsilon(0.05));  // 4000 coins, standard deviation 32
  CHECK(random_counts.size() > 5);
  CHECK(halves.size() > 60);  // of 70
}
