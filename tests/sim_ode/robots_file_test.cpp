// Robots that a file describes one by one.
#include <fmt/format.h>

#include <fstream>
#include <numbers>

#include "sim_ode/host/motors.hpp"
#include "sim_ode/settings.hpp"
#include "tests/sim_ode/arena_builder.hpp"
#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::sim_ode {
namespace {

// Profiles of four robots, of which `text` says something.
std::vector<RobotProfile> told(const std::string& text, const std::vector<std::int64_t>& ids = {}) {
  const tests::TemporaryDirectory folder;
  std::ofstream(folder.path() / "robots.toml") << text;
  const DriveSettings settings;
  std::vector<RobotProfile> out = draw_profiles(settings, 4, "shark", 1);
  read_profiles(folder.path() / "robots.toml", settings, out, ids);
  return out;
}

std::string refused(const std::string& text, const std::vector<std::int64_t>& ids = {}) {
  try {
    told(text, ids);
  } catch (const hal::ConfigError& error) {
    const std::string sentence = error.what();
    return sentence.substr(sentence.find("robots.toml"));
  }
  return "nothing";
}

}  // namespace

TEST_CASE("a robot of the file drives as it says") {
  // What a lab measures of a robot is what the simulated one does; what it does not say stays as drawn.
  constexpr double degree = std::numbers::pi / 180;
  const DriveSettings settings;
  const std::vector<RobotProfile> robots = told(
      "[[robot]]\nid = 2\nspeed_m_per_s = 0.008\ndrift_deg_per_s = -3\nturn_left_deg_per_s = 30\n"
      "duties = [71, 72, 61, 62]\nclock_slow = 0.004\nled_bearing_deg = -20\nir_gain = 0.5\n");
  const Motors motors(settings, robots, "shark", 1), drawn(settings, 4, "shark", 1);
  const Velocity ahead = motors.velocity(2, 61, 62);
  CHECK(ahead.ahead_m_s == doctest::Approx(0.008));
  CHECK(ahead.turn_rad_s == doctest::Approx(-3 * degree));
  CHECK(motors.velocity(2, 71, 0).turn_rad_s == doctest::Approx(30 * degree));
  CHECK(motors.velocity(2, 0, 72).turn_rad_s ==
        doctest::Approx(drawn.velocity(2, 0, drawn.profiles()[2].duties.turn_right).turn_rad_s));
  CHECK(motors.velocity(1, 70, 70).ahead_m_s == drawn.velocity(1, 70, 70).ahead_m_s);
  CHECK(robots[2].clock_slow == 0.004);
  CHECK(robots[2].led_bearing_rad == doctest::Approx(-20 * degree));
  CHECK(robots[2].infrared_gain == 0.5);
  CHECK(robots[1].led_bearing_rad == doctest::Approx(-44 * degree));
}

TEST_CASE("robots of the file go by the arena's ids") {
  // Where ids are stated, the file names robots by them, as a testbed does; the error of an LED's bearing is accepted.
  const std::vector<std::int64_t> ids = {7, 100, 101, 200};
  const std::vector<RobotProfile> robots =
      told("[[robot]]\nid = 100\nled_bearing_deg = -20\nled_bearing_error_deg = 0.5\n", ids);
  CHECK(robots[1].led_bearing_rad == doctest::Approx(-20 * std::numbers::pi / 180));
  CHECK(robots[0].led_bearing_rad == doctest::Approx(-44 * std::numbers::pi / 180));
  for (const char* id : {"2", "150", "201"})
    CHECK(refused(fmt::format("[[robot]]\nid = {}\n", id), ids).find("is not one of the arena's robots") !=
          std::string::npos);
}

TEST_CASE("a wrong file of robots is refused with its line") {
  // One sentence each: unknown key, robot twice, robot that is not there, no id, out of range.
  CHECK(refused("[[robot]]\nid = 1\nsped_m_per_s = 1\n") ==
        "robots.toml:3: unknown key 'robot[0].sped_m_per_s'; did you mean 'robot[0].speed_m_per_s'?");
  CHECK(refused("[[robot]]\nid = 1\n[[robot]]\nid = 1\n")
            .starts_with("robots.toml:4: robot[1].id = 1: robot 1 has a table"));
  CHECK(refused("[[robot]]\nid = 4\n") == "robots.toml:2: robot[0].id = 4: the arena's robots are 0 to 3");
  CHECK(refused("[[robot]]\nspeed_m_per_s = 0.01\n").find("robot[0].id: is missing") != std::string::npos);
  CHECK(refused("[[robot]]\nid = 0\ncharge = 2\n") == "robots.toml:3: robot[0].charge = 2: must be between 0 and 1");
  CHECK_THROWS_WITH_AS(TestArena{.ode = "robots_file = \"none.toml\""}.make(),
                       doctest::Contains("none.toml\": there is no such file"), hal::ConfigError);
}

TEST_CASE("a louder robot is heard farther") {
  // Robots 12 cm apart: the one with a gain of 1.3 is heard by the other and does not hear it.
  const tests::TemporaryDirectory folder;
  std::ofstream(folder.path() / "robots.toml") << "[[robot]]\nid = 0\nir_gain = 1.3\n";
  const auto arena = TestArena{.program = "chatter.c",
                               .robots = 2,
                               .ode = "start_poses = [0, 0, 0, 0.12, 0, 0]\nrobots_file = \"" +
                                      (folder.path() / "robots.toml").string() + "\""}
                         .make_running();
  arena->advance_to(seconds(10));
  CHECK(arena->counters()["infrared.received"] > 10);
  CHECK(arena->counters()["infrared.received"] < arena->counters()["infrared.sent"] * 0.6);
}

}  // namespace arkmesh::sim_ode
