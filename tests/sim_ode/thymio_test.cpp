// Simulated Thymios: wheels that a lab sets, a program that moves them, words, and what is refused by name.
#include "hal/robot/thymio.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "hal/robot/set_point.hpp"
#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode::of_thymios {
namespace {

using Kind = hal::FleetCommand::Kind;

// Two of them, headed east, without a program of the lab's.
std::unique_ptr<hal::Arena> thymios(const std::string& keys = "", double side_m = 2) {
  const auto config = hal::Config::from_text(
      fmt::format("[arena]\nwidth_m = {0}\nheight_m = {0}\nrobots = 2\n[arena.ode]\nrobot = \"thymio\"\n"
                  "start_poses = [-0.5, 0.5, 0, -0.5, -0.5, 0]\n{1}\n",
                  side_m, keys),
      "thymios.toml");
  auto out = make_ode_arena(config.root().section("arena"), "b", 1);
  config.refuse_unknown();
  out->robots().command({.kind = Kind::run});
  return out;
}

void drive(hal::Arena& arena, hal::RobotId robot, int left_mm_s, int right_mm_s) {
  const std::vector<hal::ToRobot> words{hal::to_robot(robot, hal::SetPoint{left_mm_s, right_mm_s})};
  arena.robots().offer(words);
}

hal::Pose at(hal::Arena& arena, double s, std::size_t robot = 0) {
  return frame_at(arena, seconds(s)).robots.at(robot).pose;
}

}  // namespace

TEST_CASE("thymio: wheels") {
  // Set points drive straight and turn about the axle, each robot by its own; they stay in force until the next ones.
  const auto arena = thymios();
  drive(*arena, 0, 100, 100);
  drive(*arena, 1, -50, 50);
  const hal::Pose a0 = at(*arena, 1), b0 = frame_at(*arena, seconds(1.1)).robots.at(1).pose;
  const hal::Pose a1 = at(*arena, 3);
  CHECK(a1.x_m - a0.x_m == doctest::Approx(0.2).epsilon(0.001));
  CHECK(a1.y_m == doctest::Approx(0.5).epsilon(1e-6));
  const hal::Pose b1 = frame_at(*arena, seconds(3.1)).robots.at(1).pose;
  const double turned = 2 * 0.1 / hal::thymio().drive.wheels_apart_m;
  CHECK(std::remainder(b1.heading_rad - b0.heading_rad - turned, 2 * std::numbers::pi) ==
        doctest::Approx(0).epsilon(1e-3));
  // the axle stays where it is
  const double behind_m = hal::thymio().drive.axle_behind_m;
  CHECK(b1.x_m - behind_m * std::cos(b1.heading_rad) == doctest::Approx(-0.5 - behind_m).epsilon(0.001));
  CHECK(b1.y_m - behind_m * std::sin(b1.heading_rad) == doctest::Approx(-0.5).epsilon(0.001));
  drive(*arena, 0, 0, 0);
  at(*arena, 3.3);
  const hal::Pose stands = at(*arena, 4);
  CHECK(at(*arena, 5).x_m == stands.x_m);
}

TEST_CASE("thymio: too fast") {
  // Wheels turn no faster than they can, and a wall stops them where the body is as wide as its kind says.
  const auto arena = thymios();
  drive(*arena, 0, 2000, 2000);
  const double from = at(*arena, 1).x_m;
  CHECK(at(*arena, 2).x_m - from == doctest::Approx(0.2).epsilon(0.001));
  CHECK(at(*arena, 20).x_m == doctest::Approx(1 - hal::thymio().body_radius_m).epsilon(0.001));
}

TEST_CASE("thymio: pause") {
  // Paused robots stand, and go on with what their wheels were set to.
  const auto arena = thymios();
  drive(*arena, 0, 100, 100);
  at(*arena, 1);
  arena->robots().command({.kind = Kind::pause});
  const double paused = at(*arena, 2).x_m;
  CHECK(at(*arena, 4).x_m == paused);
  arena->robots().command({.kind = Kind::run});
  CHECK(at(*arena, 6).x_m > paused + 0.15);
}

TEST_CASE("thymio: reset") {
  // A robot that begins anew stands until its wheels are set again.
  const auto arena = thymios();
  drive(*arena, 0, 100, 100);
  at(*arena, 1);
  arena->robots().command({.kind = Kind::reset});
  const double reset = at(*arena, 2).x_m;
  arena->robots().command({.kind = Kind::run});
  CHECK(at(*arena, 4).x_m == reset);
  drive(*arena, 0, 100, 100);
  CHECK(at(*arena, 6).x_m > reset + 0.15);
}

TEST_CASE("thymio: words") {
  // The program that it starts with shows the colour of the newest word; a word moves nobody.
  const auto arena = thymios();
  const double from = at(*arena, 0.5).x_m;
  const std::vector<hal::ToRobot> words{{.robot = 1, .kind = 3}};
  arena->robots().offer(words);
  const hal::PoseFrame frame = frame_at(*arena, seconds(1));
  CHECK(frame.robots[0].led == hal::Led::off);
  CHECK(frame.robots[1].led == hal::Led::yellow);
  CHECK(frame.robots[0].pose.x_m == from);
}

TEST_CASE("thymio: proximity") {
  // A robot that turns away while its front sensor is said to see something never touches the wall; each word names a
  // sensor of its kind, and what leads away from all walls is said to be clear.
  const auto arena = thymios();
  const auto kinds = arena->info().says;
  REQUIRE(kinds.size() == 7);
  std::array<int, 7> seen{};
  int words = 0;
  for (int k = 1; k <= 600; ++k) {
    const hal::PoseFrame frame = frame_at(*arena, seconds(0.1 * k));
    for (const hal::FromRobot& said : arena->robots().heard()) {
      REQUIRE(said.kind < kinds.size());
      CHECK(said.value >= 0);
      if (said.robot == 0) seen[said.kind] = said.value, ++words;
    }
    const bool blocked = std::max({seen[1], seen[2], seen[3]}) > 1500;
    drive(*arena, 0, blocked ? -60 : 100, blocked ? 60 : 100);
    const hal::Pose& pose = frame.robots[0].pose;
    CHECK(std::max(std::abs(pose.x_m), std::abs(pose.y_m)) < 1 - hal::thymio().body_radius_m - 0.005);
  }
  CHECK(words > 10);
  CHECK(arena->counters()["contacts.solved"] == 0);
}

TEST_CASE("thymio: a Kilobot's program") {
  // A C program for kilolib drives it: its first motor is the right wheel, at its fastest at a duty of 255.
  const auto arena =
      TestArena{.program = "ahead.c", .side_m = 3, .ode = "robot = \"thymio\"\nstart_poses = [0, 0, 0]"}.make_running();
  const hal::Pose from = at(*arena, 1);
  CHECK(at(*arena, 3).x_m - from.x_m == doctest::Approx(2 * 0.2 * 65 / 255).epsilon(0.01));
}

TEST_CASE("thymio: refused by name") {
  // What a Thymio cannot do is refused by its name, as keys of Kilobots are.
  const auto arena = thymios();
  CHECK(arena->info().make == "thymio");
  for (const auto kind : {Kind::sleep, Kind::voltage, Kind::charge, Kind::broadcast})
    arena->robots().command({.kind = kind});
  const hal::Counters& counters = arena->counters();
  for (const char* name : {"sleep", "voltage", "charge", "broadcast"})
    CHECK(counters["fleet_command.refused." + std::string(name)] == 1);
  for (const char* key : {"turn_deg_per_s = 30", "battery_led_ma = 3.0", "ir_loss = 0.5", "ir_flat_m = 0.1"})
    CHECK_THROWS_WITH_AS(thymios(key),
                         doctest::Contains("applies to Kilobots only, not to robot = \"thymio\"; remove it"),
                         hal::ConfigError);
  CHECK_THROWS_WITH_AS(thymios("", 0.1), doctest::Contains("too many for an arena of 0.1 m x 0.1 m"), hal::ConfigError);
  const auto kilobots = TestArena{.robots = 2}.make();
  drive(*kilobots, 0, 10, 10);
  CHECK(kilobots->counters()["to_robots.refused.value"] == 1);
}

TEST_CASE("thymio: many meet") {
  // A crowd that pushes stays apart by its bodies, and the same seed gives the same places.
  const auto run = [] {
    const auto config = hal::Config::from_text(
        "[arena]\nwidth_m = 1.2\nheight_m = 1.2\nrobots = 20\n[arena.ode]\nrobot = \"thymio\"\n", "crowd.toml");
    auto arena = make_ode_arena(config.root().section("arena"), "b", 7);
    arena->robots().command({.kind = Kind::run});
    for (hal::RobotId robot = 0; robot < 20; ++robot) drive(*arena, robot, 150, 120 + 4 * static_cast<int>(robot));
    return frame_at(*arena, seconds(10));
  };
  const hal::PoseFrame one = run(), other = run();
  const double apart_m = 2 * hal::thymio().body_radius_m;
  for (std::size_t i = 0; i < one.robots.size(); ++i) {
    CHECK(one.robots[i].pose.x_m == other.robots[i].pose.x_m);
    CHECK(one.robots[i].pose.heading_rad == other.robots[i].pose.heading_rad);
    for (std::size_t j = 0; j < i; ++j)
      CHECK(std::hypot(one.robots[i].pose.x_m - one.robots[j].pose.x_m,
                       one.robots[i].pose.y_m - one.robots[j].pose.y_m) > apart_m - 0.002);
  }
}

}  // namespace arkmesh::sim_ode::of_thymios
