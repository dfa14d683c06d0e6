// Pheromone: what is laid, what becomes of it, what robots smell.
#include "scenarios/kit/pheromone.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "hal/random.hpp"

namespace arkmesh::scenarios::kit {
namespace {

double all(const Pheromone& field) {
  return std::accumulate(field.cells().begin(), field.cells().end(), 0.0);
}

}  // namespace

TEST_CASE("kit: pheromone lies in the cell of its place, up to the cap, and nowhere outside") {
  Pheromone field({.width_m = 1, .height_m = 0.5, .cell_m = 0.1, .cap = 3});
  CHECK(field.columns() == 10);
  CHECK(field.rows() == 5);
  hal::RandomStream random(1, "test/pheromone");
  for (int i = 0; i < 1000; ++i) {
    const hal::Point p{random.uniform(-0.6, 0.6), random.uniform(-0.35, 0.35)};
    const int cell = field.cell_at(p);
    CHECK((cell >= 0) == (std::abs(p.x_m) <= 0.5 && std::abs(p.y_m) <= 0.25));
    if (cell < 0) continue;
    const hal::Point c = field.centre_of(cell);
    CHECK(std::max(std::abs(c.x_m - p.x_m), std::abs(c.y_m - p.y_m)) <= 0.05 + 1e-9);
  }
  for (int i = 0; i < 5; ++i) field.lay({0.01, 0.01}, 1);
  field.lay({0.01, 0.01}, -7);
  field.lay({7, 0}, 1);
  CHECK(field.at({0.09, 0.04}) == 3);
  CHECK(all(field) == 3);
}

TEST_CASE("kit: half is left after the half-life, linear decay ends at nothing, little is cut off") {
  Pheromone half({.half_life_s = 10}), linear({.linear_per_s = 0.08}), cut({.half_life_s = 10, .cut_off = 0.5});
  for (Pheromone* field : {&half, &linear, &cut}) field->lay({}, 1.2);
  for (int i = 0; i < 100; ++i)
    for (Pheromone* field : {&half, &linear, &cut}) field->pass(0.1);
  CHECK(half.at({}) == doctest::Approx(0.6).epsilon(1e-9));
  CHECK(linear.at({}) == doctest::Approx(0.4).epsilon(1e-9));
  CHECK(cut.at({}) == doctest::Approx(0.6).epsilon(1e-9));
  half.pass(10);
  linear.pass(10);
  cut.pass(10);
  CHECK(half.at({}) == doctest::Approx(0.3).epsilon(1e-9));
  CHECK(linear.at({}) == 0);
  CHECK(cut.at({}) == 0);
}

TEST_CASE("kit: what spreads widens by 2 D t in each direction, drifts with the wind, and is all there") {
  const double d = 2e-4, wind = 0.002;
  Pheromone field({.width_m = 1, .height_m = 1, .cell_m = 0.01, .diffusion_m2_s = d, .wind_x_m_s = wind});
  field.lay({0.005, 0.005}, 1000);
  for (int i = 0; i < 10; ++i) field.pass(1);
  CHECK(all(field) == doctest::Approx(1000).epsilon(1e-9));
  double mean_x = 0, mean_y = 0, square_x = 0, square_y = 0;
  for (int cell = 0; cell < static_cast<int>(field.cells().size()); ++cell) {
    const hal::Point c = field.centre_of(cell);
    const double share = field.in_cell(cell) / 1000;
    CHECK(share >= 0);
    mean_x += share * c.x_m;
    mean_y += share * c.y_m;
    square_x += share * c.x_m * c.x_m;
    square_y += share * c.y_m * c.y_m;
  }
  CHECK(mean_x == doctest::Approx(0.005 + 10 * wind).epsilon(1e-6));
  CHECK(mean_y == doctest::Approx(0.005).epsilon(1e-6));
  CHECK(square_y - mean_y * mean_y == doctest::Approx(2 * d * 10).epsilon(1e-3));
  // upwind steps spread a little more along the wind
  CHECK(square_x - mean_x * mean_x == doctest::Approx(2 * d * 10 + wind * 0.01 * 10).epsilon(0.06));
}

TEST_CASE("kit: the gradient points up the slope") {
  Pheromone field({.width_m = 1, .height_m = 1, .cell_m = 0.1});
  for (int cell = 0; cell < 100; ++cell) {
    const hal::Point c = field.centre_of(cell);
    field.lay_in(cell, 5 + 2 * c.x_m - 3 * c.y_m);
  }
  for (const hal::Point p : {hal::Point{0, 0}, hal::Point{-0.49, 0.49}, hal::Point{0.49, -0.2}}) {
    CHECK(field.gradient(p).x_m == doctest::Approx(2));
    CHECK(field.gradient(p).y_m == doctest::Approx(-3));
  }
  CHECK(field.gradient({2, 0}).x_m == 0);
}

TEST_CASE("kit: zones in front hold the cells whose centres lie there") {
  hal::RandomStream random(1, "test/zones");
  for (int round = 0; round < 1000; ++round) {
    Pheromone field({.width_m = 0.5, .height_m = 0.5, .cell_m = 0.01});
    for (int i = 0; i < 60; ++i)
      field.lay({random.uniform(-0.25, 0.25), random.uniform(-0.25, 0.25)}, random.uniform(0, 2));
    const hal::Pose robot{random.uniform(-0.25, 0.25), random.uniform(-0.25, 0.25), random.uniform(-3, 3)};
    const int count = 1 + static_cast<int>(random.below(8));
    const double opening = random.uniform(0.5, 2 * std::numbers::pi), radius = random.uniform(0.02, 0.1), least = 0.5;
    std::uint32_t expected = 0;
    for (int cell = 0; cell < 2500; ++cell) {
      const hal::Point c = field.centre_of(cell);
      const double x = c.x_m - robot.x_m, y = c.y_m - robot.y_m;
      if (field.in_cell(cell) < least || std::hypot(x, y) > radius) continue;
      const double bearing = std::remainder(std::atan2(y, x) - robot.heading_rad, 2 * std::numbers::pi);
      const int zone = static_cast<int>(std::floor((opening / 2 - bearing) / opening * count));
      if (zone >= 0 && zone < count) expected |= 1U << (count - 1 - zone);
    }
    CHECK(field.zones(robot, count, opening, radius, least) == expected);
  }
}

TEST_CASE("kit: pheromones that are none are refused in one sentence") {
  const auto refused = [](const Pheromone::Settings& settings) {
    try {
      Pheromone field(settings);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(refused({.cell_m = 1e-6}) ==
        "cell = 1e-06 of a pheromone: makes 1000000 x 1000000 cells, and the limit is 1048576; use larger cells");
  CHECK(refused({.cell_m = 0}) == "cell = 0 of a pheromone: must be positive");
  CHECK(refused({.half_life_s = -1}) == "half_life = -1 of a pheromone: must be 0 or more");
  CHECK(refused({.wind_x_m_s = std::numeric_limits<double>::infinity()}).ends_with("must be a number"));
  Pheromone fast({.cell_m = 0.01, .diffusion_m2_s = 1e3});
  CHECK_THROWS_WITH_AS(fast.pass(2), doctest::Contains("use larger cells"), std::invalid_argument);
  CHECK_THROWS_WITH_AS(fast.zones({}, 4, 1, 10, 0.1), doctest::Contains("use larger cells"), std::invalid_argument);
}

}  // namespace arkmesh::scenarios::kit
