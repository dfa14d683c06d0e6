// The null arena, the common [arena] keys and the pacer. What every arena promises: tests/conformance.
#include "hal/arenas/null_arena.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "hal/arenas/arena_config.hpp"
#include "hal/time/pacer.hpp"

using namespace arkmesh::hal;

namespace {

const RobotKind robot{.body_radius_m = 0.0165};

std::string error(const std::string& keys) {
  try {
    read_arena_config(Config::from_text("[arena]\n" + keys, "a.toml").root().section("arena"), robot.body_radius_m);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("the common arena keys are checked") {
  // One bad value per rule.
  struct Row {
    std::string keys, message;
  };
  const std::vector<Row> rows{
      {"width_m = 0.5\nheight_m = 0.25\nrobots = 12\nframe_period_s = 0.055\npace = 1", ""},
      {"robots = 0", ""},
      {"width_m = -1", "a.toml:2: arena.width_m = -1: must be between 0.001 and 100"},
      {"height_m = 0", "a.toml:2: arena.height_m = 0: must be between 0.001 and 100"},
      {"height_m = 100.5", "a.toml:2: arena.height_m = 100.5: must be between 0.001 and 100"},
      {"width_m = nan", "a.toml:2: arena.width_m = nan: must be a finite number"},
      {"robots = -1", "a.toml:2: arena.robots = -1: must be between 0 and 100000"},
      {"robots = 1000000", "a.toml:2: arena.robots = 1000000: must be between 0 and 100000"},
      {"width_m = 100\nheight_m = 100\nrobots = 100000", ""},
      {"robots = 842",
       "a.toml:2: arena.robots = 842: too many for an arena of 1 m x 1 m, which holds 841; make it larger or use "
       "fewer"},
      {"robots = 841", ""},
      {"frame_period_s = 0", "a.toml:2: arena.frame_period_s = 0: must be between 1e-06 and 60"},
      {"frame_period_s = 0.0000015",
       "a.toml:2: arena.frame_period_s = 1.5e-06: must be a whole number of microseconds"},
      {"frame_period_s = -0.1", "a.toml:2: arena.frame_period_s = -0.1: must be between 1e-06 and 60"},
      {"pace = 0.5", "a.toml:2: arena.pace = 0.5: must be 0 (as fast as asked) or 1 (real time)"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.keys);
    CHECK(error(row.keys) == row.message);
  }
}

TEST_CASE("robots of the null arena stand apart inside it") {
  // Any number in any shape of arena; no two on the same spot; they never move.
  for (const int robots : {0, 1, 2, 7, 48, 400}) {
    CAPTURE(robots);
    const Config config =
        Config::from_text("[arena]\nwidth_m = 2\nheight_m = 0.5\nrobots = " + std::to_string(robots), "a.toml");
    const auto arena = make_null_arena(config.root().section("arena"), "lab", robot);
    arena->advance_to(LabTime{0});
    const auto first = arena->poses().latest();
    REQUIRE(first);
    REQUIRE(first->robots.size() == static_cast<std::size_t>(robots));
    for (std::size_t i = 0; i < first->robots.size(); ++i) {
      CHECK(std::abs(first->robots[i].pose.x_m) < 1.0);
      CHECK(std::abs(first->robots[i].pose.y_m) < 0.25);
      for (std::size_t k = 0; k < i; ++k)
        CHECK_UNARY(std::hypot(first->robots[i].pose.x_m - first->robots[k].pose.x_m,
                               first->robots[i].pose.y_m - first->robots[k].pose.y_m) > 0.02);
    }
    arena->advance_to(LabTime{3'600'000'000});
    const auto last = arena->poses().latest();
    REQUIRE(last);
    CHECK(last->number == 36'000);
    CHECK(arena->counters()["poses.skipped"] == 35'999);
    for (std::size_t i = 0; i < first->robots.size(); ++i) CHECK(last->robots[i].pose.x_m == first->robots[i].pose.x_m);
  }
}

namespace {

// Time in a test's hand.
class HeldTime final : public WallTime {
 public:
  TimePoint now() override { return now_; }
  void wait_until(TimePoint then) override { now_ = std::max(now_, then); }

 private:
  TimePoint now_ = TimePoint{} + std::chrono::hours{1};
};

}  // namespace

TEST_CASE("the pacer gives absolute moments and counts being late") {
  // Time 0 is when it is first asked for a later one; reaching a time long after its moment counts once, in time not.
  using std::chrono::milliseconds;
  Counters counters;
  HeldTime wall;
  const TimePoint begun = wall.now();
  Pacer pacer(LabTime{50'000}, counters, wall);
  CHECK(pacer.reached(LabTime{0}));
  wall.wait_until(begun + milliseconds{700});
  CHECK_FALSE(pacer.reached(LabTime{20'000}));
  CHECK(pacer.next() == begun + milliseconds{720});
  CHECK_FALSE(pacer.reached(LabTime{20'000}));
  wall.wait_until(pacer.next());
  CHECK(pacer.reached(LabTime{20'000}));
  CHECK(pacer.next() == TimePoint::max());
  wall.wait_until(begun + milliseconds{790});
  CHECK(pacer.reached(LabTime{40'000}));
  CHECK(counters["late"] == 0);
  CHECK(pacer.reached(LabTime{39'000}));
  CHECK(counters["late"] == 1);
  CHECK_FALSE(pacer.reached(LabTime{91'000}));
  CHECK(counters["late"] == 1);
}
