// The world of CRE: places, resources that come back in their region, and what flying robots see of them.
#include "scenarios/cre/places.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numeric>
#include <set>

using namespace arkmesh;
namespace cre = scenarios::cre;
using cre::Region;

namespace {

std::vector<std::int64_t> resources_by_region(const std::vector<hal::Pose>& places,
                                              const std::vector<std::int64_t>& active) {
  std::vector<std::int64_t> n{0, 0};
  for (std::size_t i = 0; i < places.size(); ++i) n[cre::index(cre::region_of(places[i]))] += active[i];
  return n;
}

}  // namespace

TEST_CASE("cre places: a grid in two halves") {
  // 10 x 10 places of the 2 m arena are 0.2 m apart, half of them north of the border and half south, none on it.
  const auto places = cre::places_on_grid(10, 2, 2);
  REQUIRE(places.size() == 100);
  CHECK(places[0].x_m == doctest::Approx(-0.9));
  CHECK(places[0].y_m == doctest::Approx(0.9));
  CHECK(places[99].x_m == doctest::Approx(0.9));
  CHECK(places[99].y_m == doctest::Approx(-0.9));
  for (std::size_t i = 0; i < 100; ++i) CHECK(cre::region_of(places[i]) == (i < 50 ? Region::north : Region::south));
  // A mirror image: what is in row r from the north is in row r from the south.
  for (std::size_t i = 0; i < 100; ++i) {
    const hal::Pose& mirrored = places[(9 - i / 10) * 10 + i % 10];
    CHECK(mirrored.x_m == places[i].x_m);
    CHECK(mirrored.y_m == doctest::Approx(-places[i].y_m));
  }
}

TEST_CASE("cre places: a harvested resource appears elsewhere in its region") {
  // Harvesting keeps each region's number, never gives the same place again at once, counts by region, and reaches all
  // places in the end.
  hal::RandomStream random(1, "test");
  const auto places = cre::places_on_grid(10, 2, 2);
  cre::Resources resources(places, 10, 35, random);
  CHECK(resources_by_region(places, resources.active()) == std::vector<std::int64_t>{10, 35});
  std::set<std::size_t> seen;
  std::vector<std::int64_t> harvested{0, 0};
  for (int round = 0; round < 40; ++round)
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto before = resources.active();
      hal::Pose robot = places[i];
      robot.x_m += 0.019;
      const bool found = resources.harvest(robot, 0.02, random);
      REQUIRE(found == (before[i] == 1));
      if (!found) {
        REQUIRE(resources.active() == before);
        continue;
      }
      ++harvested[i < 50 ? 0 : 1];
      CHECK(resources.active()[i] == 0);
      CHECK(resources_by_region(places, resources.active()) == std::vector<std::int64_t>{10, 35});
      for (std::size_t j = 0; j < places.size(); ++j)
        if (before[j] == 0 && resources.active()[j] == 1) seen.insert(j);
    }
  CHECK(resources.harvested() == harvested);
  CHECK(harvested[0] > 100);
  CHECK(harvested[1] > 100);
  CHECK(seen.size() == 100);
  // Nothing where no place is, and nothing from a place that is too far.
  CHECK(!resources.harvest({.x_m = 0, .y_m = 0}, 0.02, random));
  for (const hal::Pose& place : places)
    CHECK(!resources.harvest({.x_m = place.x_m, .y_m = place.y_m + 0.021}, 0.02, random));
}

TEST_CASE("cre places: one free place is enough") {
  // With all places but one taken, the next resource appears there.
  hal::RandomStream random(2, "test");
  cre::Resources resources(cre::places_on_grid(2, 2, 2), 1, 1, random);
  for (int i = 0; i < 4; ++i) {
    const auto before = resources.active();
    const auto places = cre::places_on_grid(2, 2, 2);
    for (std::size_t p = 0; p < 2; ++p)
      if (before[p] == 1) CHECK(resources.harvest(places[p], 0.02, random));
    CHECK(resources.active()[0] == before[1]);
    CHECK(resources.active()[1] == before[0]);
  }
}

TEST_CASE("cre places: what a flying robot sees") {
  // Active and all places within the radius, by region; the mirror image of a robot over the mirror image of the
  // resources sees north and south swapped.
  const auto places = cre::places_on_grid(10, 2, 2);
  hal::RandomStream random(3, "test");
  cre::Resources resources(places, 10, 35, random);
  const auto& active = resources.active();
  std::vector<std::int64_t> mirrored(100);
  for (std::size_t i = 0; i < 100; ++i) mirrored[(9 - i / 10) * 10 + i % 10] = active[i];
  for (int n = 0; n < 1000; ++n) {
    const hal::Pose at{.x_m = random.uniform(-1, 1), .y_m = random.uniform(-1, 1)};
    const cre::Sight seen = cre::look(at, 0.32, places, active);
    std::array<int, 2> all{}, with{};
    for (std::size_t i = 0; i < 100; ++i)
      if (std::hypot(places[i].x_m - at.x_m, places[i].y_m - at.y_m) < 0.32) {
        ++all[i < 50 ? 0 : 1];
        with[i < 50 ? 0 : 1] += active[i] == 1;
      }
    CHECK(seen.places == all);
    CHECK(seen.active == with);
    const cre::Sight other = cre::look({.x_m = at.x_m, .y_m = -at.y_m}, 0.32, places, mirrored);
    CHECK(other.places == std::array{all[1], all[0]});
    CHECK(other.active == std::array{with[1], with[0]});
  }
  CHECK(cre::look({.x_m = 0, .y_m = 0.9}, 0.32, places, active).places[1] == 0);
}
