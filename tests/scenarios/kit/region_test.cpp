// Regions and schedules, against brute force.
#include "scenarios/kit/region.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "hal/random.hpp"

namespace arkmesh::scenarios::kit {
namespace {

// By the sum of the angles under which the sides are seen: a whole turn from inside.
bool is_around(const std::vector<hal::Point>& corners, const hal::Point& p) {
  double turned = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const hal::Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    turned += std::remainder(std::atan2(b.y_m - p.y_m, b.x_m - p.x_m) - std::atan2(a.y_m - p.y_m, a.x_m - p.x_m),
                             2 * std::numbers::pi);
  }
  return std::abs(turned) > std::numbers::pi;
}

}  // namespace

TEST_CASE("kit: places in a disc and in polygons that are stars") {
  hal::RandomStream random(1, "test/regions");
  for (int round = 0; round < 40; ++round) {
    const int n = 3 + static_cast<int>(random.below(8));
    std::vector<hal::Point> corners;
    double least = 1;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * (i + random.uniform(0.1, 0.9)) / n, far = random.uniform(0.1, 0.5);
      least = std::min(least, far);
      corners.push_back({far * std::cos(angle), far * std::sin(angle)});
    }
    const Region star = Region::polygon(corners);
    const Region disc = Region::disc(corners[0], 0.2);
    int inside = 0, drawn = 4000;
    for (int i = 0; i < drawn; ++i) {
      const hal::Point p{random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)};
      inside += star.contains(p);
      if (i < 1000) CHECK(star.contains(p) == is_around(corners, p));
      CHECK(disc.contains(p) == (std::hypot(p.x_m - corners[0].x_m, p.y_m - corners[0].y_m) <= 0.2));
    }
    const double part = static_cast<double>(inside) / drawn;
    CHECK(std::abs(part - star.area_m2()) < 4 * std::sqrt(0.25 / drawn));
  }
}

TEST_CASE("kit: regions that are none are refused in one sentence") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS(Region::disc({}, 0), "a disc of radius 0 m is not a region; give a positive radius",
                       std::invalid_argument);
  CHECK_THROWS_AS(Region::disc({}, nan), std::invalid_argument);
  CHECK_THROWS_WITH(Region::polygon({{0, 0}, {1, 0}}), "a polygon needs at least 3 corners, not 2");
  CHECK_THROWS_WITH(Region::polygon({{0, 0}, {1, 1}, {1, 0}, {0, 1}}),
                    "a polygon's sides cross; give its corners in order");
  CHECK_THROWS_WITH(Region::polygon({{0, 0}, {1, 0}, {2, 0}}), doctest::Contains("a polygon"));
  CHECK_THROWS_WITH(Region::polygon({{0, 0}, {1, nan}, {2, 0}}), "a polygon's corners must be numbers, not NaN");
}

TEST_CASE("kit: a schedule's value holds from its time on") {
  const Schedule quality({{0, 1.0}, {60, 0.5}, {90, 2.0}});
  for (const auto& [time_s, value] :
       {std::pair(-1.0, 1.0), std::pair(0.0, 1.0), std::pair(59.9, 1.0), std::pair(60.0, 0.5), std::pair(1e9, 2.0)})
    CHECK(quality.at(time_s) == value);
  CHECK_THROWS_WITH(Schedule({}), "a schedule needs at least one value");
  CHECK_THROWS_WITH(Schedule({{0, 1}, {0, 2}}), "the times of a schedule must ascend");
}

}  // namespace arkmesh::scenarios::kit
