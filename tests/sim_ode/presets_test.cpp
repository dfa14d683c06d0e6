// Presets of the simulated robots.
#include <cmath>

#include "sim_ode/settings.hpp"
#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {
namespace {

std::string in_force(const std::string& ode) {
  const auto config = hal::Config::from_text("[arena.ode]\ncontroller = \"a.c\"\n" + ode, "test.toml");
  read_settings(config.root().section("arena"));
  config.refuse_unknown();
  return config.effective();
}

}  // namespace

TEST_CASE("a preset sets what the file does not state") {
  // "measured" changes keys of drive, clock and battery; a stated key wins, whatever the preset; "ideal" is the
  // default; what is in force loads again with the same values.
  const std::string measured = in_force("preset = \"measured\"\nstart_duty = 7\nspeed_m_per_s = 0.02");
  CHECK(measured.find("start_duty = 7\n") != std::string::npos);
  CHECK(measured.find("speed_m_per_s = 0.02") != std::string::npos);
  for (const char* key :
       {"dead_duty = 40\n", "clock_spread = 0.005\n", "battery_mah = 160", "turn_noise_deg_per_s = 2"})
    CHECK(measured.find(key) != std::string::npos);
  CHECK(in_force("preset = \"measured_0\"").find("ir_range_m = 0.1\n") != std::string::npos);
  CHECK(in_force("") == in_force("preset = \"ideal\""));
  CHECK(in_force("").find("start_duty = 0\n") != std::string::npos);
  const auto again = hal::Config::from_text(measured, "test.toml");
  read_settings(again.root().section("arena"));
  CHECK(again.effective() == measured);
  CHECK_THROWS_WITH_AS(
      in_force("preset = \"real\""),
      "test.toml:3: arena.ode.preset = \"real\": must be one of \"ideal\", \"measured\", \"measured_0\"",
      hal::ConfigError);
}

TEST_CASE("measured robots repeat") {
  // What wanders, sticks and runs down does not depend on how the time is sliced.
  const TestArena scene{.robots = 20, .side_m = 0.4, .ode = "preset = \"measured\"\nbattery_mah = 0.2"};
  auto one = scene.make_running(), two = scene.make_running();
  for (int k = 1; k < 2000; ++k) one->advance_to(hal::LabTime(k * 7'919));
  const hal::PoseFrame sliced = frame_at(*one, seconds(16)), whole = frame_at(*two, seconds(16));
  for (std::size_t i = 0; i < 20; ++i) {
    const hal::Pose &a = sliced.robots[i].pose, &b = whole.robots[i].pose;
    CHECK((a.x_m == b.x_m && a.y_m == b.y_m && a.heading_rad == b.heading_rad));
  }
  CHECK(one->counters()["robots.battery_empty"] == two->counters()["robots.battery_empty"]);
}

TEST_CASE("measured robots wander and ideal ones do not") {
  // Ten equal robots that drive straight on for 20 s: ideal ones all keep their course, measured ones are off by about
  // 2 deg/s x sqrt(2 x 2 s x 20 s) = 18 degrees.
  const auto course_off = [](const std::string& preset) {
    auto arena =
        TestArena{.program = "all_ahead.c",
                  .robots = 10,
                  .side_m = 3,
                  .ode = std::string(exact_drive) + "\npreset = \"" + preset + "\"\nstart_duty = 0\nclock_spread = 0"}
            .make_running();
    const hal::PoseFrame before = frame_at(*arena, seconds(1)), after = frame_at(*arena, seconds(21));
    double sum = 0;
    for (std::size_t i = 0; i < 10; ++i) {
      const double off =
          std::remainder(after.robots[i].pose.heading_rad - before.robots[i].pose.heading_rad, 6.2831853);
      sum += off * off;
    }
    return std::sqrt(sum / 10) * 57.29578;
  };
  CHECK(course_off("ideal") < 1e-6);
  CHECK(course_off("measured") > 8);
  CHECK(course_off("measured") < 40);
}

}  // namespace arkmesh::sim_ode
