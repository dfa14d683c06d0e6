// What stands in light's way: shapes for lamps and infrared, robots' bodies for infrared.
#include "sim_ode/shadows.hpp"

#include <cmath>
#include <numbers>

#include "sim_ode/light_field.hpp"
#include "tests/sim_ode/standing_robots.hpp"

namespace arkmesh::sim_ode {

TEST_CASE("lines past a shape") {
  // A line meets a disc or a polygon when it passes through its inside, between its ends; grazing is no meeting, and
  // the order of corners does not matter.
  const Shadows nothing;
  CHECK(!nothing.between({-1, 0}, {1, 0}));

  const Shadows disc{{Blocker::disc({0, 0}, 0.1)}};
  CHECK(disc.between({-1, 0}, {1, 0}));
  CHECK(disc.between({-1, 0.099}, {1, 0.099}));
  CHECK(!disc.between({-1, 0.1}, {1, 0.1}));  // along its edge
  CHECK(!disc.between({-1, 0}, {-0.1, 0}));   // up to it
  CHECK(disc.between({-1, 0}, {-0.099, 0}));
  CHECK(!disc.between({0.2, -1}, {0.2, 1}));
  CHECK(disc.between({0, 0}, {0, 0}));  // inside

  for (const bool clockwise : {false, true}) {
    CAPTURE(clockwise);
    std::vector<Point> corners{{0.1, -0.2}, {0.1, 0.2}, {-0.1, 0.2}, {-0.1, -0.2}};
    if (clockwise) std::reverse(corners.begin(), corners.end());
    const Shadows box{{Blocker::polygon(corners)}};
    CHECK(box.between({-1, 0.05}, {1, -0.05}));
    CHECK(box.between({-1, 0.199}, {1, 0.199}));
    CHECK(!box.between({-1, 0.2}, {1, 0.2}));   // along an edge
    CHECK(!box.between({0, 0.3}, {0.2, 0.1}));  // through a corner
    CHECK(box.between({0, 0.299}, {0.2, 0.099}));
    CHECK(!box.between({-1, 0}, {-0.1, 0}));  // up to it
    CHECK(!box.between({-1, 0.3}, {1, 0.25}));
    CHECK(box.between({0, 0}, {0.01, 0.01}));  // inside
    // within the circle round it, beside the box
    CHECK(!box.between({0.11, -1}, {0.11, 1}));
  }
}

TEST_CASE("a lamp behind a shape") {
  // The sensor reads the dark behind a shape, the lamp when the shape has gone or stands aside, and the room's even
  // light whatever stands there.
  Settings settings;
  settings.lamps = {{1, 0, 0}};
  settings.light_noise = 0;
  LightField field(settings, 1, "shark", 1);
  const std::pair<double, double> facing{std::cos(-100 * std::numbers::pi / 180),
                                         std::sin(-100 * std::numbers::pi / 180)};
  const std::int16_t open = field.reading(0, 0, 0, facing);
  CHECK(open > 100);
  Shadows shadows{{Blocker::disc({0.5, 0}, 0.05)}};
  field.set_blockers(&shadows);
  CHECK(field.reading(0, 0, 0, facing) == 0);
  shadows.blockers[0].centre.y_m = 0.06;
  CHECK(field.reading(0, 0, 0, facing) == open);
  settings.lamps.clear();
  LightField even(settings, 1, "shark", 1);
  shadows.blockers[0].centre.y_m = 0;
  even.set_blockers(&shadows);
  CHECK(even.reading(0, 0, 0, facing) == 400);
}

TEST_CASE("infrared behind a wall") {
  // A wall between two robots ends their talk; those on one side of it hear each other.
  const Shadows wall{{Blocker::polygon({{-0.001, -0.05}, {0.001, -0.05}, {0.001, 0.05}, {-0.001, 0.05}})}};
  Standing robots({{-0.03, 0, 0}, {0.03, 0, 0}, {0.03, 0.06, 0}}, {}, 1, "chatter.c", &wall);
  for (int k = 0; k < 200; ++k) robots.step();
  CHECK(robots.heard(0, 1) == 0);
  CHECK(robots.heard(1, 0) == 0);
  CHECK(robots.heard(1, 2) > 8);
  CHECK(robots.heard(2, 1) > 8);
}

}  // namespace arkmesh::sim_ode
