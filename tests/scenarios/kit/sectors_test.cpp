// Virtual proximity sensors, against rays.
#include "scenarios/kit/sectors.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "hal/random.hpp"
#include "scenarios/wall_sensor.hpp"

namespace arkmesh::scenarios::kit {
namespace {

constexpr double pi = std::numbers::pi, none = std::numeric_limits<double>::infinity();

// How far a ray from a place goes.
double ray(const hal::Point& from, double angle_rad, const Surroundings& what) {
  const double x = std::cos(angle_rad), y = std::sin(angle_rad);
  double far = none;
  for (const auto& side : what.sides()) {
    const double ax = side.from.x_m - from.x_m, ay = side.from.y_m - from.y_m, bx = side.to.x_m - side.from.x_m,
                 by = side.to.y_m - side.from.y_m, across = bx * y - by * x;
    if (std::abs(across) < 1e-12) continue;
    const double at = (ay * x - ax * y) / across, along = (ay * bx - ax * by) / across;
    if (at >= 0 && at <= 1 && along >= 0) far = std::min(far, along);
  }
  for (const auto& disc : what.discs()) {
    const double cx = disc.centre.x_m - from.x_m, cy = disc.centre.y_m - from.y_m, along = cx * x + cy * y,
                 room = disc.radius_m * disc.radius_m - (cx * cx + cy * cy - along * along);
    if (room >= 0 && along > 0) far = std::min(far, along - std::sqrt(room));
  }
  return far;
}

}  // namespace

TEST_CASE("kit: what eyes see is what the shortest of many rays meets") {
  hal::RandomStream random(1, "test/sectors");
  std::vector<hal::Obstacle> obstacles(2);
  obstacles[0].shape.radius_m = 0.08;
  obstacles[0].pose = {0.2, 0.1, 0};
  obstacles[1].shape.corners = {{-0.1, -0.03}, {0.1, -0.03}, {0.1, 0.03}, {-0.1, 0.03}};
  obstacles[1].pose = {-0.2, -0.1, 0.7};
  const Surroundings what(1.0, 0.7, obstacles);
  constexpr int rays = 400;
  for (int round = 0; round < 1000; ++round) {
    const Sectors::Settings settings{.count = 1 + static_cast<int>(random.below(16)),
                                     .around = random.below(2) == 1,
                                     .reach_m = random.uniform(0.05, 0.5)};
    const hal::Pose robot{random.uniform(-0.48, 0.48), random.uniform(-0.33, 0.33), random.uniform(-pi, pi)};
    const auto is_in = [&](const hal::Point& p) {
      const double dx = p.x_m - 0.2, dy = p.y_m - 0.1;
      const double x = std::cos(0.7) * (p.x_m + 0.2) + std::sin(0.7) * (p.y_m + 0.1),
                   y = -std::sin(0.7) * (p.x_m + 0.2) + std::cos(0.7) * (p.y_m + 0.1);
      return dx * dx + dy * dy < 0.0065 || (std::abs(x) < 0.101 && std::abs(y) < 0.031);
    };
    if (is_in({robot.x_m, robot.y_m})) continue;
    const auto seen = Sectors(settings).distances_m(robot, what);
    REQUIRE(seen.size() == static_cast<std::size_t>(settings.count));
    const double wide = (settings.around ? 2 * pi : pi) / settings.count;
    for (int sector = 0; sector < settings.count; ++sector) {
      double nearest = none;
      for (int i = 0; i <= rays; ++i) {
        const double share = static_cast<double>(i) / rays;
        const double angle = settings.around ? (sector + share) * wide : pi / 2 - (sector + share) * wide;
        nearest = std::min(nearest, ray({robot.x_m, robot.y_m}, robot.heading_rad + angle, what));
      }
      CAPTURE(round);
      CAPTURE(sector);
      const double there = seen[static_cast<std::size_t>(sector)];
      // rays may miss the nearest point by a little
      if (nearest <= settings.reach_m - 1e-9) {
        CHECK(there <= nearest + 1e-9);
        CHECK(there >= nearest - 0.02);
      } else {
        CHECK((there == none || there >= settings.reach_m - 0.02));
      }
    }
  }
}

TEST_CASE("kit: levels grow with nearness, and bits have the leftmost sector first") {
  const Surroundings arena(1, 1);
  const Sectors front({.count = 4, .reach_m = 0.1, .levels = 10});
  // 3 cm from the east wall, heading north: the wall is on its right
  const auto levels = front.levels({0.47, 0, pi / 2}, arena);
  CHECK(levels == std::vector<int>{0, 0, 6, 7});
  CHECK(Sectors::bits(levels) == 0b0011);
  CHECK(front.levels({0, 0, 0}, arena) == std::vector<int>(4, 0));
}

TEST_CASE("kit: half planes are what the published eyes see of walls") {
  hal::RandomStream random(1, "test/half_planes");
  const Surroundings arena(1, 0.7);
  const Sectors front({.count = 8, .reach_m = 0.1, .half_planes = true, .levels = 1});
  int seen = 0;
  for (int round = 0; round < 5000; ++round) {
    const hal::Pose robot{random.uniform(-0.49, 0.49), random.uniform(-0.34, 0.34), random.uniform(-pi, pi)};
    const auto bits = Sectors::bits(front.levels(robot, arena));
    CHECK(bits == blocked_sectors(robot, 1, 0.7, 0.1));
    seen += bits != 0;
  }
  CHECK(seen > 1000);
  // of two obstacles the nearer one, straight ahead, and not the other one's half plane
  std::vector<hal::Obstacle> obstacles(2);
  obstacles[0].shape.radius_m = obstacles[1].shape.radius_m = 0.05;
  obstacles[0].pose = {0.1, 0, 0};
  obstacles[1].pose = {0, 0.12, 0};
  CHECK(Sectors::bits(front.levels({0, 0, 0}, {1, 1, obstacles})) == 0xff);
  obstacles[0].pose = {0, -0.11, 0};
  CHECK(Sectors::bits(front.levels({0, 0, 0}, {1, 1, obstacles})) == 0x0f);
}

TEST_CASE("kit: with a margin, obstacles seem nearer in the sectors where they are, and walls do not") {
  std::vector<hal::Obstacle> obstacles(2);
  obstacles[0].shape.radius_m = 0.08;
  obstacles[0].pose = {0.2, 0.1, 0};
  obstacles[1].shape.corners = {{-0.1, -0.03}, {0.1, -0.03}, {0.1, 0.03}, {-0.1, 0.03}};
  obstacles[1].pose = {-0.2, -0.1, 0.7};
  constexpr double reach = 0.1, margin = 0.04;
  const Sectors far({.count = 6, .around = true, .reach_m = reach + margin}),
      near({.count = 6, .around = true, .reach_m = reach});
  const Surroundings bare(4, 4, obstacles), padded(4, 4, obstacles, margin), walls(0.5, 0.5, {}, margin);
  hal::RandomStream random(1, "test/margin");
  for (int round = 0; round < 2000; ++round) {
    const hal::Pose robot{random.uniform(-0.5, 0.5), random.uniform(-0.4, 0.4), random.uniform(-pi, pi)};
    const auto wanted = far.distances_m(robot, bare), seen = near.distances_m(robot, padded);
    for (std::size_t i = 0; i < seen.size(); ++i)
      CHECK(seen[i] == (wanted[i] < 1 ? std::max(0.0, wanted[i] - margin) : none));
  }
  CHECK(near.distances_m({0.2, 0, 0}, walls)[0] == doctest::Approx(0.05));
}

TEST_CASE("kit: sensors that are none are refused in one sentence") {
  CHECK_THROWS_WITH_AS(Sectors({.count = 0}), "a sensor of 0 sectors is not possible; give 1 to 16",
                       std::invalid_argument);
  CHECK_THROWS_WITH(Sectors({.reach_m = 0}), "a reach of 0 m is not possible; give a positive one");
  CHECK_THROWS_WITH(Sectors({.levels = 0}), "0 levels are not possible; give 1 to 255");
}

}  // namespace arkmesh::scenarios::kit
