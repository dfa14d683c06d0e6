// The robots' programs of CRE: what they do with messages, and their build for the robot.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenarios/cre/controller/cre_messages.h"
#include "scenarios/cre/settings.hpp"
#include "sim_ode/ode_arena.hpp"
#include "tests/scenarios/avr_build.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using hal::Led;
namespace cre = scenarios::cre;

namespace {

// A simulated arena full of robots with one of CRE's programs, stepped frame by frame.
class CreRobots {
 public:
  // `poses`: x, y, heading of each robot.
  CreRobots(const std::string& program, const std::string& poses, std::uint64_t seed, double side_m = 1,
            const std::string& more = "")
      : config_(hal::Config::from_text(
            fmt::format(
                "[arena]\nrobots = {}\nwidth_m = {}\nheight_m = {}\n[arena.ode]\nspeed_spread = 0\ncontroller = "
                "\"{}/scenarios/cre/controller/{}.c\"\nstart_poses = [{}]\n{}",
                (std::count(poses.begin(), poses.end(), ',') + 1) / 3, side_m, side_m, ARKMESH_SOURCE_DIR, program,
                poses, more),
            "test.toml")),
        arena_(sim_ode::make_ode_arena(config_.root().section("arena"), "lab", seed)) {
    arena_->advance_to(0us);
    arena_->robots().command({.kind = hal::FleetCommand::Kind::run});
    frame_ = *arena_->poses().latest();
  }
  void say(hal::RobotId robot, std::uint8_t slot, std::uint8_t kind, std::uint16_t value) {
    const hal::ToRobot message{.robot = robot, .slot = slot, .kind = kind, .value = value};
    arena_->robots().offer({&message, 1});
  }
  // Densities in 1/30.
  void tell_densities(hal::RobotId robot, int north, int south) {
    say(robot, CRE_READING_SLOT, CRE_NO_WALL, static_cast<std::uint16_t>(north << 5 | south));
  }
  void tell_rules(const cre::Settings& settings) { arena_->robots().command(cre::rules_of(settings)); }
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
  void command(hal::FleetCommand::Kind kind) { arena_->robots().command({.kind = kind}); }
  const hal::Observation& seen(hal::RobotId robot) const { return frame_.robots.at(robot); }
  const std::vector<hal::Observation>& all() const { return frame_.robots; }
  std::size_t showing(Led led) const {
    return static_cast<std::size_t>(
        std::count_if(all().begin(), all().end(), [&](const hal::Observation& o) { return o.led == led; }));
  }
  std::uint64_t sent() const { return arena_->counters()["infrared.sent"]; }

 private:
  hal::Config config_;
  std::unique_ptr<hal::Arena> arena_;
  hal::PoseFrame frame_;
  hal::LabTime now_{0};
};

// `n` robots on a line, `apart_m` from each other.
std::string in_line(int n, double apart_m) {
  std::string poses;
  for (int i = 0; i < n; ++i) poses += fmt::format("{}{}, 0.0, 0.0", i ? ", " : "", (i - (n - 1) / 2.0) * apart_m);
  return poses;
}

// Robots that decide all the time, and whom nothing but their own sensors moves.
cre::Settings quick() {
  cre::Settings settings;
  settings.commit = 1;
  settings.recruit = 0;
  settings.abandon = 0;
  settings.weight = 1;
  settings.decision = 500ms;
  return settings;
}

double heading_error(const CreRobots& robots, hal::RobotId robot, double wanted) {
  return std::abs(std::remainder(robots.seen(robot).pose.heading_rad - wanted, 2 * std::numbers::pi));
}

}  // namespace

TEST_CASE("cre flying: the LED shows to which region a robot has committed itself") {
  // With resources in one region only, it is that one; with none, or before any reading, it is neither. North and south
  // are alike.
  CreRobots robots("flying", in_line(3, 0.3), 5);
  robots.advance(200ms);
  robots.tell_rules(quick());
  robots.advance(5s);
  CHECK(robots.showing(Led::off) == 3);
  robots.tell_densities(0, CRE_FULL, 0);
  robots.tell_densities(1, 0, CRE_FULL);
  robots.tell_densities(2, 0, CRE_NO_PLACE);
  robots.advance(10s);
  CHECK(robots.seen(0).led == Led::red);
  CHECK(robots.seen(1).led == Led::blue);
  CHECK(robots.seen(2).led == Led::off);
}

TEST_CASE("cre flying: a committed robot gives up what it finds empty") {
  // Spontaneous abandonment: for sure where the estimate is zero, never with a = 0.
  CreRobots robots("flying", in_line(2, 0.3), 6);
  cre::Settings settings = quick();
  robots.advance(200ms);
  robots.tell_rules(settings);
  for (hal::RobotId robot : {0, 1}) robots.tell_densities(robot, CRE_FULL, 0);
  robots.advance(10s);
  CHECK(robots.showing(Led::red) == 2);
  for (hal::RobotId robot : {0, 1}) robots.tell_densities(robot, 0, 0);
  robots.advance(10s);
  CHECK(robots.showing(Led::red) == 2);
  settings.abandon = 0.01;
  robots.tell_rules(settings);
  CHECK(robots.until(0, Led::off, 3s) < 2s);
  CHECK(robots.until(1, Led::off, 3s) < 2s);
}

TEST_CASE("cre flying: committed robots recruit and inhibit those that hear them") {
  // By infrared: a robot that would never commit itself follows a committed neighbour, and one of the other opinion
  // gives its own up; robots out of reach do not.
  cre::Settings settings = quick();
  CreRobots robots("flying", "0.0, 0.0, 0.0, 0.05, 0.0, 0.0, 0.4, 0.4, 0.0", 7, 1,
                   "speed_m_per_s = 0.0\nturn_deg_per_s = 0.0\n");
  robots.advance(200ms);
  robots.tell_rules(settings);
  robots.tell_densities(0, 0, CRE_FULL);
  robots.advance(10s);
  CHECK(robots.seen(0).led == Led::blue);
  CHECK(robots.sent() > 10);
  settings.commit = 0;
  settings.recruit = 1;
  robots.tell_rules(settings);
  for (hal::RobotId robot : {1, 2}) robots.tell_densities(robot, CRE_FULL, CRE_FULL);
  robots.advance(10s);
  CHECK(robots.seen(1).led == Led::blue);  // recruited
  CHECK(robots.seen(2).led == Led::off);   // too far away
  // Two neighbours of opposite opinions, of whom each would keep its own; once opinions count, the one whose
  // neighbour's region is the better one gives up.
  CreRobots pair("flying", in_line(2, 0.05), 8, 1, "speed_m_per_s = 0.0\nturn_deg_per_s = 0.0\n");
  settings = quick();
  pair.advance(200ms);
  pair.tell_rules(settings);
  pair.tell_densities(0, CRE_FULL, 0);
  pair.tell_densities(1, 0, CRE_FULL);
  pair.advance(10s);
  CHECK(pair.seen(0).led == Led::red);
  CHECK(pair.seen(1).led == Led::blue);  // recruit = 0: nobody minds
  settings.commit = 0;
  settings.recruit = 1;
  for (hal::RobotId robot : {0, 1}) pair.tell_densities(robot, CRE_FULL, 0);
  pair.advance(500ms);
  pair.tell_rules(settings);
  CHECK(pair.until(1, Led::off, 10s) < 10s);  // the north is full
  CHECK(pair.seen(0).led == Led::red);        // and the south empty
}

TEST_CASE("cre flying: what a neighbour said is forgotten at a decision") {
  // A robot is recruited by what it has heard since its last decision only.
  CreRobots robots("flying", in_line(2, 0.05), 13, 1, "speed_m_per_s = 0.0\nturn_deg_per_s = 0.0\n");
  cre::Settings settings = quick();
  settings.abandon = 0.01;
  robots.advance(200ms);
  robots.tell_rules(settings);
  robots.tell_densities(0, CRE_FULL, 0);
  robots.tell_densities(1, 0, 0);
  robots.advance(10s);
  CHECK(robots.seen(0).led == Led::red);
  CHECK(robots.seen(1).led == Led::off);
  // Robot 0 falls silent; a while later robot 1 would follow whatever it hears.
  robots.tell_densities(0, 0, 0);
  CHECK(robots.until(0, Led::off, 5s) < 5s);
  robots.advance(3s);
  settings.commit = 0;
  settings.recruit = 1;
  robots.tell_rules(settings);
  robots.tell_densities(1, CRE_FULL, CRE_FULL);
  robots.advance(5s);
  CHECK(robots.seen(1).led == Led::off);
}

TEST_CASE("cre flying: how often an opinion is sent") {
  // Twice a second while committed, not at all uncommitted, and once for each decision if the rules say so.
  const std::string standing = "speed_m_per_s = 0.0\nturn_deg_per_s = 0.0\n";
  CreRobots robots("flying", in_line(1, 1), 9, 1, standing);
  cre::Settings settings = quick();
  settings.decision = 5s;
  settings.decide_together = true;
  robots.advance(200ms);
  robots.tell_rules(settings);
  robots.advance(8s);
  CHECK(robots.sent() == 0);
  robots.tell_densities(0, CRE_FULL, CRE_FULL);
  robots.until(0, Led::red, 5s);
  robots.advance(1s);
  const std::uint64_t before = robots.sent();
  robots.advance(20s);
  CHECK(robots.sent() - before >= 36);
  CHECK(robots.sent() - before <= 40);
  settings.say_once = true;
  robots.tell_rules(settings);
  robots.advance(6s);
  const std::uint64_t then = robots.sent();
  robots.advance(20s);
  CHECK(robots.sent() - then >= 3);
  CHECK(robots.sent() - then <= 5);
}

TEST_CASE("cre flying: robots decide in phases of their own, or all together") {
  // The moments at which 20 robots commit themselves are spread over the time between decisions, unless they decide
  // together.
  for (bool together : {false, true}) {
    CreRobots robots("flying", in_line(20, 0.11), 10, 3);
    cre::Settings settings = quick();
    settings.decision = 10s;
    settings.decide_together = together;
    robots.advance(200ms);
    robots.tell_rules(settings);
    for (hal::RobotId robot = 0; robot < 20; ++robot) robots.tell_densities(robot, CRE_FULL, CRE_FULL);
    std::size_t moments = 0, known = 0;
    for (int n = 0; n < 110; ++n) {
      robots.advance(100ms);
      const std::size_t committed = 20 - robots.showing(Led::off);
      moments += committed > known;
      known = committed;
    }
    CHECK(known == 20);
    CHECK((together ? moments == 1 : moments > 10));
  }
}

TEST_CASE("cre flying: a robot that was paused does not make up for missed decisions") {
  // After a pause of 200 s, which are 20 decisions, 20 robots that commit themselves in one decision of five have taken
  // about one each, not all of them.
  CreRobots robots("flying", in_line(20, 0.11), 14, 3);
  cre::Settings settings = quick();
  settings.commit = 0.2;
  settings.decision = 10s;
  robots.advance(200ms);
  robots.tell_rules(settings);
  robots.advance(500ms);
  for (hal::RobotId robot = 0; robot < 20; ++robot) robots.tell_densities(robot, CRE_FULL, CRE_FULL);
  robots.advance(1s);
  robots.command(hal::FleetCommand::Kind::pause);
  robots.advance(200s);
  robots.command(hal::FleetCommand::Kind::run);
  robots.advance(1s);
  CHECK(20 - robots.showing(Led::off) < 12);
  robots.advance(100s);
  CHECK(20 - robots.showing(Led::off) > 14);
}

TEST_CASE("cre ground: a robot that hears turns to the region by its compass and goes straight") {
  // From every heading it ends up heading for the region to within 20 degrees, the shorter way round, showing red or
  // blue while it turns and white while it goes, for the time that it was told; then it walks.
  const int n = 8;
  std::string poses;
  for (int i = 0; i < n; ++i)
    poses += fmt::format("{}{}, 0.0, {}", i ? ", " : "", (i - 3.5) * 0.2, -3.0 + i * 2 * std::numbers::pi / n);
  for (bool north : {true, false}) {
    CreRobots robots("ground", poses, 11, 3);
    cre::Settings settings;
    settings.straight = 3s;
    robots.tell_rules(settings);
    robots.advance(300ms);
    for (hal::RobotId robot = 0; robot < n; ++robot) {
      const double heading = robots.seen(robot).pose.heading_rad / (2 * std::numbers::pi) * static_cast<int>(CRE_TURN);
      robots.say(robot, CRE_HEARD_SLOT, north ? CRE_HEARD_NORTH : CRE_HEARD_SOUTH,
                 static_cast<std::uint16_t>((std::lround(heading) + CRE_TURN) % CRE_TURN));
    }
    robots.advance(400ms);
    const double wanted = (north ? 1 : -1) * std::numbers::pi / 2;
    std::vector<double> begun(n, -1), ended(n, -1), off(n, 0), heading_then(n), turned_later(n);
    std::vector<bool> turned(n);
    for (int tenths = 0; tenths < 100; ++tenths) {
      for (hal::RobotId robot = 0; robot < n; ++robot) {
        const Led led = robots.seen(robot).led;
        turned[robot] = turned[robot] || led == (north ? Led::red : Led::blue);
        if (led == Led::white && begun[robot] < 0) {
          begun[robot] = tenths * 0.1;
          off[robot] = heading_error(robots, robot, wanted);
        }
        if (led == Led::off && begun[robot] >= 0 && ended[robot] < 0) {
          ended[robot] = tenths * 0.1;
          heading_then[robot] = robots.seen(robot).pose.heading_rad;
        }
        if (ended[robot] >= 0 && std::abs(tenths * 0.1 - ended[robot] - 1) < 0.05)
          turned_later[robot] = heading_error(robots, robot, heading_then[robot]);
      }
      robots.advance(100ms);
    }
    for (int robot = 0; robot < n; ++robot) {
      CAPTURE(robot);
      CHECK(begun[robot] >= 0);
      CHECK(begun[robot] < 4.2);
      CHECK(ended[robot] - begun[robot] == doctest::Approx(3.0).epsilon(0.08));
      CHECK(off[robot] < 20 * std::numbers::pi / 180);
    }
    CHECK(std::count(turned.begin(), turned.end(), true) >= n - 1);
    // Then it goes on in that direction: a straight of its walk lasts 11 s in the mean.
    CHECK(std::count_if(turned_later.begin(), turned_later.end(), [](double turn) { return turn < 0.1; }) >= n - 2);
  }
}

TEST_CASE("cre ground: a wall comes first") {
  // A robot that is told of a wall turns away from it, whatever it was doing, and hears nobody meanwhile.
  CreRobots robots("ground", "0.0, 0.0, 0.0", 12);
  robots.advance(300ms);
  robots.say(0, CRE_HEARD_SLOT, CRE_HEARD_NORTH, CRE_TURN / 4);  // it heads north already, by its compass
  CHECK(robots.until(0, Led::white, 2s) < 1s);
  const double before = robots.seen(0).pose.heading_rad;
  robots.say(0, CRE_WALL_SLOT, CRE_WALL_LEFT, 0);
  CHECK(robots.until(0, Led::off, 2s) < 500ms);
  robots.say(0, CRE_HEARD_SLOT, CRE_HEARD_NORTH, 0);
  robots.advance(1s);
  CHECK(robots.seen(0).led == Led::off);
  CHECK(std::remainder(robots.seen(0).pose.heading_rad - before, 2 * std::numbers::pi) < -0.5);  // to the right
}

TEST_CASE("cre controllers: build for the robot") {
  scenarios::check_builds_for_robot({"scenarios/cre/controller/flying.c", "scenarios/cre/controller/ground.c"});
}
