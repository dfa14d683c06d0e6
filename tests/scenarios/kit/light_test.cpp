// Virtual light beside a walk along a beam's path in small steps.
#include "scenarios/kit/light.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hal/random.hpp"

namespace arkmesh::scenarios::kit {

TEST_CASE("kit: light is what shines even, rises and wanders, at 1000 places") {
  const std::vector<hal::Point> path = {{-0.4, -0.4}, {0.4, -0.4}, {0.4, 0.4}};
  const Light::Beam beam{.level = 500, .radius_m = 0.15, .path = path, .speed_m_s = 0.05};
  const Light light({.ambient = 100, .slope_per_m = {200, -50}, .beams = {beam}});
  hal::RandomStream random(1, "test/light");
  for (int round = 0; round < 1000; ++round) {
    const hal::Point at{random.uniform(-1, 1), random.uniform(-1, 1)};
    const double seconds = random.uniform(0, 200);
    const double around = 1.6 + std::sqrt(2) * 0.8, along = std::fmod(0.05 * seconds, around);
    hal::Point middle;
    if (along < 0.8)
      middle = {-0.4 + along, -0.4};
    else if (along < 1.6)
      middle = {0.4, -0.4 + along - 0.8};
    else
      middle = {0.4 - (along - 1.6) / std::sqrt(2), 0.4 - (along - 1.6) / std::sqrt(2)};
    const double apart = std::hypot(at.x_m - middle.x_m, at.y_m - middle.y_m);
    if (std::abs(apart - 0.15) < 1e-6) continue;
    const double expected = 100 + 200 * at.x_m - 50 * at.y_m + (apart < 0.15 ? 500 : 0);
    CHECK(light.at(at, hal::LabTime{std::llround(seconds * 1e6)}) ==
          doctest::Approx(std::clamp(expected, 0.0, 1023.0)).epsilon(1e-6));
  }
}

TEST_CASE("kit: a beam that stays, and beams that are none") {
  const Light light({.beams = {{.path = {{0.1, 0}}, .speed_m_s = 1}, {.path = {{1, 1}, {1, 1}}, .speed_m_s = 1}}});
  CHECK(light.at({0.1, 0}, hal::LabTime{12'345'678}) == 1023);
  CHECK(light.at({0, 0.5}, hal::LabTime{0}) == 0);
  CHECK_THROWS_WITH_AS(Light({.beams = {{}}}), "a beam's path needs at least one place", std::invalid_argument);
  CHECK_THROWS_WITH(Light({.beams = {{.radius_m = 0, .path = {{0, 0}}}}}),
                    "a beam's radius of 0 m is not possible; give a positive one");
}

}  // namespace arkmesh::scenarios::kit
