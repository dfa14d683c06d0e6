// The robots' program of DHTF: its states, its walls, and its build for the robot.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lab/robots/robot_words.hpp"
#include "scenarios/dhtf/controller/dhtf_messages.h"
#include "scenarios/dhtf/robot_messages.hpp"
#include "scenarios/wall_sensor.hpp"
#include "sim_ode/ode_arena.hpp"
#include "tests/scenarios/avr_build.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using hal::Led;
using scenarios::dhtf::dwelling, scenarios::dhtf::leaving, scenarios::dhtf::walking;

namespace {

// A simulated arena full of DHTF robots, stepped frame by frame.
class Robots {
 public:
  Robots(int n, double side_m, std::uint64_t seed)
      : config_(hal::Config::from_text(
            fmt::format("[arena]\nrobots = {}\nwidth_m = {}\nheight_m = {}\n[arena.ode]\ncontroller = "
                        "\"{}/scenarios/dhtf/controller/dhtf.c\"\n",
                        n, side_m, side_m, ARKMESH_SOURCE_DIR),
            "test.toml")),
        arena_(sim_ode::make_ode_arena(config_.root().section("arena"), "lab", seed)) {
    arena_->advance_to(0us);
    arena_->robots().command({.kind = hal::FleetCommand::Kind::run});
    frame_ = *arena_->poses().latest();
  }
  void say(hal::RobotId robot, std::uint8_t kind, std::uint16_t value) {
    const hal::ToRobot message{.robot = robot, .slot = DHTF_SLOT, .kind = kind, .value = value};
    arena_->robots().offer({&message, 1});
  }
  void advance(hal::LabTime by) {
    for (hal::LabTime end = now_ + by; now_ < end;) {
      now_ += 100ms;
      arena_->advance_to(now_);
      if (auto frame = arena_->poses().latest()) frame_ = *frame;
    }
  }
  // Lab time until the robot shows `led`; at most `most`.
  hal::LabTime until(hal::RobotId robot, Led led, hal::LabTime most) {
    const hal::LabTime begun = now_;
    while (seen(robot).led != led && now_ - begun < most) advance(100ms);
    return now_ - begun;
  }
  const hal::Observation& seen(hal::RobotId robot) const { return frame_.robots.at(robot); }
  double moved_m(hal::RobotId robot, hal::LabTime in) {
    const hal::Pose before = seen(robot).pose;
    advance(in);
    return std::hypot(seen(robot).pose.x_m - before.x_m, seen(robot).pose.y_m - before.y_m);
  }
  const hal::PoseFrame& frame() const { return frame_; }

 private:
  hal::Config config_;
  std::unique_ptr<hal::Arena> arena_;
  hal::PoseFrame frame_;
  hal::LabTime now_{0};
};

}  // namespace

TEST_CASE("dhtf controller: states") {
  // Walking, dwelling and leaving follow each other as messages and time have it, and the LED shows which.
  Robots robots(1, 1.0, 5);
  robots.advance(200ms);
  CHECK(robots.seen(0).led == walking);
  CHECK(robots.moved_m(0, 5s) > 0.01);

  // A task makes it stand still for the time it is told, then leave.
  robots.say(0, DHTF_TASK, 5);
  CHECK(robots.until(0, dwelling, 1s) < 500ms);
  CHECK(robots.moved_m(0, 4s) < 1e-4);
  CHECK(robots.until(0, leaving, 10s) < 1500ms);
  CHECK(robots.moved_m(0, 5s) > 0.01);

  // Leaving, it ignores tasks and closed sites, until it is outside.
  robots.say(0, DHTF_TASK, 60);
  robots.advance(1s);
  CHECK(robots.seen(0).led == leaving);
  robots.say(0, DHTF_CLOSED, 0);
  robots.advance(1s);
  CHECK(robots.seen(0).led == leaving);
  robots.say(0, DHTF_OUTSIDE, 0);
  CHECK(robots.until(0, walking, 1s) < 500ms);

  // Dwelling, it is released by an executed task, or by being pushed out, long before its time.
  for (std::uint8_t release : {DHTF_CLOSED, DHTF_OUTSIDE}) {
    robots.say(0, DHTF_TASK, 60);
    CHECK(robots.until(0, dwelling, 1s) < 500ms);
    robots.say(0, release, 0);
    CHECK(robots.until(0, walking, 1s) < 500ms);
    CHECK(robots.moved_m(0, 5s) > 0.005);
  }

  // A repeated task does not lengthen the stay.
  robots.say(0, DHTF_TASK, 3);
  robots.until(0, dwelling, 1s);
  for (int i = 0; i < 2; ++i) robots.advance(1s), robots.say(0, DHTF_TASK, 3);
  CHECK(robots.until(0, leaving, 10s) < 1500ms);
}

TEST_CASE("dhtf controller: addresses") {
  // Of three robots in one message each obeys its own block, whichever it is, and a fourth none.
  Robots robots(4, 1.0, 6);
  robots.advance(1s);
  for (hal::RobotId spared : {0, 1, 2}) {
    for (hal::RobotId robot : {0, 1, 2}) robots.say(robot, robot == spared ? DHTF_CLOSED : DHTF_TASK, 1);
    robots.advance(500ms);
    for (hal::RobotId robot : {0, 1, 2}) CHECK(robots.seen(robot).led == (robot == spared ? walking : dwelling));
    CHECK(robots.seen(3).led == walking);
    robots.advance(2s);
    for (hal::RobotId robot : {0, 1, 2}) robots.say(robot, DHTF_OUTSIDE, 0);
    robots.advance(500ms);
  }
}

TEST_CASE("dhtf controller: walls") {
  // With the wall sensor on, walkers spend little time against the walls, and never get stuck there; with it off, they
  // do.
  const auto touching = [](bool sensor) {
    Robots robots(12, 0.5, 7);
    lab::RobotWords messages;
    int touches = 0, seen = 0;
    for (int n = 0; n < 3000; ++n) {
      robots.advance(100ms);
      for (const hal::Observation& s : robots.frame().robots) {
        touches += std::max(std::abs(s.pose.x_m), std::abs(s.pose.y_m)) > 0.25 - 0.0165 - 0.001;
        ++seen;
        const std::uint8_t sectors = sensor ? scenarios::blocked_sectors(s.pose, 0.5, 0.5, 0.066) : std::uint8_t{0};
        const auto told = scenarios::dhtf::message_for({.wall_sectors = sectors}, s.led);
        const hal::ToRobot word{.robot = s.robot, .kind = told.kind, .value = told.value};
        if (messages.due(robots.frame().stamp, word, told.shown, 1s)) robots.say(word.robot, word.kind, word.value);
      }
    }
    return static_cast<double>(touches) / seen;
  };
  const double with = touching(true), without = touching(false);
  MESSAGE("share of robot-time against a wall: ", with, " with the sensor, ", without, " without");
  CHECK(with < 0.05);
  CHECK(without > 0.3);
}

TEST_CASE("dhtf controller: builds for the robot") {
  scenarios::check_builds_for_robot({"scenarios/dhtf/controller/dhtf.c", "experiments/light_up/light_up.c"});
}
