// Neighbours, bearings, resources and floors of the kit.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "hal/random.hpp"
#include "scenarios/kit/bearing.hpp"
#include "scenarios/kit/floor_map.hpp"
#include "scenarios/kit/neighbours.hpp"
#include "scenarios/kit/resource.hpp"

namespace arkmesh::scenarios::kit {

TEST_CASE("kit: neighbours are those that all pairs give") {
  hal::RandomStream random(1, "test/neighbours");
  for (int round = 0; round < 200; ++round) {
    std::vector<Seen> all(random.below(60));
    for (Seen& each : all)
      each = {{random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)}, static_cast<hal::Led>(random.below(8))};
    if (all.size() > 3) all[1].place.x_m = std::numeric_limits<double>::quiet_NaN();
    const std::size_t own = all.empty() ? 0 : random.below(all.size());
    const std::span robots = std::span(all).first(own);
    const double range = random.uniform(0.01, 0.4);
    const auto leds = static_cast<LedSet>(random.below(256));
    const auto counts = neighbours(robots, all, range, leds);
    for (std::size_t i = 0; i < own; ++i) {
      int expected = 0;
      for (std::size_t k = 0; k < all.size(); ++k)
        expected += k != i && (leds >> static_cast<int>(all[k].led) & 1) != 0 &&
                    std::hypot(all[k].place.x_m - all[i].place.x_m, all[k].place.y_m - all[i].place.y_m) <= range;
      CHECK(counts[i] == expected);
    }
  }
  CHECK_THROWS_AS(neighbours({}, {}, 0), std::invalid_argument);
  const std::vector<Seen> four{{{}, hal::Led::red}, {{}, hal::Led::red}, {{}, hal::Led::off}, {{}, hal::Led::blue}};
  CHECK(share(four, only(hal::Led::red)) == 0.5);
  CHECK(share(four, any_led) == 1);
  CHECK(share({}, any_led) == 0);
}

TEST_CASE("kit: bearings and distances") {
  constexpr double pi = std::numbers::pi;
  CHECK(bearing_rad({0, 0, pi / 2}, {1, 0}) == doctest::Approx(-pi / 2));
  CHECK(bearing_rad({0, 0, 0}, {-1, 0}) == doctest::Approx(pi));
  CHECK(bearing_rad({1, 1, 2}, {1, 1}) == 0);
  CHECK(distance_m({0, 0, 1}, {3, 4}) == doctest::Approx(5));
}

TEST_CASE("kit: a resource grows as the logistic equation says, and is taken as far as it is there") {
  Resource stock({.capacity = 10, .growth_per_s = 0.1});
  CHECK(stock.take(9) == 9);
  for (int i = 0; i < 200; ++i) stock.pass(0.1, 0);
  const double grown = std::exp(0.1 * 20);
  CHECK(stock.stock() == doctest::Approx(grown / (1 + 0.1 * (grown - 1))).epsilon(1e-9));
  CHECK(stock.put(100) == doctest::Approx(10 - grown / (1 + 0.1 * (grown - 1))));
  CHECK(stock.stock() == 10);
  Resource shared({.capacity = 10, .rate_per_s = 0.005}),
      pairs({.capacity = 10, .rate_per_s = 0.005, .use = Resource::Use::by_pairs});
  CHECK(shared.pass(2, 4) == doctest::Approx(0.4));
  CHECK(pairs.pass(2, 4) == doctest::Approx(1.6));
  CHECK(pairs.pass(1000, 40) == doctest::Approx(8.4));
  CHECK(pairs.pass(1, 1) == 0);
  Resource common({.capacity = 10, .rate_per_s = 0.005, .use = Resource::Use::shared});
  CHECK(common.pass(2, 4) == doctest::Approx(0.1));
  CHECK(common.pass(2, 1) == doctest::Approx(0.1));
  CHECK(common.pass(2, 0) == 0);
  Resource renewed({.capacity = 10, .regrows_at_once_below = 1});
  renewed.take(9.5);
  CHECK(renewed.stock() == 10);
  CHECK_THROWS_WITH_AS(Resource({.capacity = 0}), "a capacity of 0 is not possible; give a positive one",
                       std::invalid_argument);
  CHECK_THROWS_AS(Resource({.growth_per_s = -1}), std::invalid_argument);
}

TEST_CASE("kit: a floor's levels have their shares, and patches make neighbours alike") {
  const FloorMap::Size size{.width_m = 1, .height_m = 0.5, .columns = 40, .rows = 20};
  double alike[2];
  for (const int patch : {0, 2}) {
    hal::RandomStream random(1, "test/floor");
    const FloorMap floor = FloorMap::drawn(size, {3, 1}, patch, random);
    CHECK(std::ranges::count(floor.tiles(), 0) == 600);
    int same = 0, pairs = 0;
    for (std::size_t i = 0; i + 1 < floor.tiles().size(); ++i) {
      if (i % 40 == 39) continue;
      ++pairs;
      same += floor.tiles()[i] == floor.tiles()[i + 1];
    }
    alike[patch / 2] = static_cast<double>(same) / pairs;
  }
  CHECK(alike[0] == doctest::Approx(0.625).epsilon(0.08));  // 0.75^2 + 0.25^2
  CHECK(alike[1] > 0.8);
  std::vector<std::uint8_t> tiles(800);
  std::iota(tiles.begin(), tiles.end(), std::uint8_t{0});
  const FloorMap counted(size, tiles);
  CHECK(counted.at({-0.499, -0.249}) == 0);
  CHECK(counted.at({-0.46, -0.249}) == 1);
  CHECK(counted.at({-0.499, -0.22}) == 40);
  CHECK(counted.at({9, 9}) == tiles.back());
  CHECK_THROWS_WITH_AS(FloorMap(size, {}), "a floor of 40 x 20 tiles has 800 levels, not 0", std::invalid_argument);
  hal::RandomStream random(1, "test/floor");
  CHECK_THROWS_AS(FloorMap::drawn(size, {0, 0}, 0, random), std::invalid_argument);
  CHECK_THROWS_AS(FloorMap::drawn(size, {1}, -1, random), std::invalid_argument);
  CHECK_THROWS_AS(FloorMap({.columns = 5000}, {}), std::invalid_argument);
}

}  // namespace arkmesh::scenarios::kit
