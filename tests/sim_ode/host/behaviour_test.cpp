// What a swarm must do whatever the details of the models: each test runs one program and looks at its robots.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tests/sim_ode/host/program_run.hpp"
#include "tests/support/processes/thorough.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;
using hal::Led;

namespace {

constexpr double diameter_m = 0.033;

// 25 robots at random places of a small arena: everybody hears several.
SwarmProgram crowd(const std::string& program) {
  SwarmProgram run(program);
  run.options.width_m = run.options.height_m = 0.3;
  return run;
}

double share(const hal::PoseFrame& frame, Led led) {
  return static_cast<double>(
             std::count_if(frame.robots.begin(), frame.robots.end(), [&](auto& robot) { return robot.led == led; })) /
         static_cast<double>(frame.robots.size());
}

}  // namespace

TEST_CASE("a gradient counts hops") {
  // Robots of a random crowd show their distance from robot 0 in hops, as a search through the robots in range finds
  // it; nine in ten at least at any one moment, as a message now and then gets through late.
  const std::map<int, Led> colours = {{1, Led::red},  {2, Led::yellow}, {3, Led::green},
                                      {4, Led::cyan}, {5, Led::blue},   {0, Led::magenta}};
  for (const std::uint64_t seed : {1, 2, 3}) {
    if (!arkmesh::tests::thorough() && seed > 1) continue;
    CAPTURE(seed);
    SwarmProgram run("gradient_hops");
    run.options.robots = 80;
    run.options.seed = seed;
    run.options.width_m = run.options.height_m = 0.65;
    run.for_seconds(60);
    REQUIRE_MESSAGE(run.failure.empty(), run.failure);
    const auto& robots = run.report.last().robots;
    std::vector<int> hops(robots.size(), -1);
    hops[0] = 0;
    std::vector<std::size_t> queue = {0};
    for (std::size_t at = 0; at < queue.size(); ++at)
      for (std::size_t k = 0; k < robots.size(); ++k)
        if (hops[k] < 0 && distance_m(robots[k].pose, robots[queue[at]].pose) < 0.1) {
          hops[k] = hops[queue[at]] + 1;
          queue.push_back(k);
        }
    int farthest = 0;
    std::size_t right = 0;
    for (std::size_t k = 0; k < robots.size(); ++k) {
      farthest = std::max(farthest, hops[k]);
      const Led expected = hops[k] < 0 ? Led::off : hops[k] == 0 ? Led::white : colours.at(hops[k] % 6);
      right += robots[k].led == expected;
    }
    MESSAGE("seed ", seed, ": ", queue.size(), " of ", robots.size(), " reached, up to ", farthest, " hops, ", right,
            " show theirs");
    CHECK(right * 10 >= robots.size() * 9);
    CHECK(farthest >= 4);
  }
}

TEST_CASE("synchronising robots flash together") {
  // At their brightest moment few of 25 robots flash together in the beginning, nearly all at the end.
  struct Case {
    std::string program;
    Led flash;
    double early_s;  // as long as they cannot have agreed yet
  };
  for (const Case& c : {Case{"sync_clock", Led::white, 0.5}, {"sync_firefly", Led::red, 8}}) {
    if (!arkmesh::tests::thorough() && c.program != "sync_clock") continue;
    SwarmProgram run = crowd(c.program);
    double before = 0, after = 0;
    run.for_seconds(c.early_s, [&](const hal::PoseFrame& frame) { before = std::max(before, share(frame, c.flash)); });
    run.for_seconds(arkmesh::tests::thorough() ? 600 : 60);
    run.for_seconds(20, [&](const hal::PoseFrame& frame) { after = std::max(after, share(frame, c.flash)); });
    CHECK_MESSAGE(run.failure.empty(), run.failure);
    MESSAGE(c.program, ": ", before, " flash together at first, ", after, " at the end");
    CHECK(before < 0.6);
    CHECK(after >= 0.9);
  }
}

TEST_CASE("nobody passes through anybody or the wall") {
  // A crowd that drives blindly into walls and each other for two minutes: at no frame is a gap below minus 2 mm.
  SwarmProgram run("labs_drive_all");
  run.options.robots = 60;
  run.options.width_m = 0.5;
  run.options.height_m = 0.4;
  double nearest = 1, outside = -1;
  run.for_seconds(120, [&](const hal::PoseFrame& frame) {
    for (const double d : sim_ode::nearest_neighbours(frame)) nearest = std::min(nearest, d);
    for (const hal::Observation& robot : frame.robots)
      outside = std::max(
          {outside, std::abs(robot.pose.x_m) + diameter_m / 2 - 0.25, std::abs(robot.pose.y_m) + diameter_m / 2 - 0.2});
  });
  REQUIRE_MESSAGE(run.failure.empty(), run.failure);
  MESSAGE("nearest centres ", nearest, " m, deepest in a wall ", outside, " m");
  CHECK(nearest > diameter_m - 0.002);
  CHECK(outside < 0.002);
  CHECK(outside > -0.001);  // somebody did reach a wall
}

TEST_CASE("a program that forgets the checksum is not heard") {
  // Its messages go on the air, are counted, and no robot's callback is called; the same robots hear a program that
  // does not forget.
  SwarmProgram mute = crowd("mute_no_crc"), well = crowd("style_no_return");
  mute.for_seconds(30);
  well.for_seconds(30);
  CHECK(mute.count("infrared.sent") > 100);
  CHECK(mute.count("infrared.received") == 0);
  CHECK(share(mute.report.last(), Led::red) == 1);
  CHECK(well.count("infrared.received") > 100);
  CHECK(share(well.report.last(), Led::green) == 1);
}

TEST_CASE("delay lasts as long as it says") {
  // Half a second on, half a second off: 60 s show each robot 119 or 120 changes, not one per tick too many or too few.
  SwarmProgram run("labs_blink");
  run.options.robots = 10;
  run.for_seconds(60);
  for (const std::uint32_t changes : run.report.colour_changes()) {
    CHECK(changes >= 118);
    CHECK(changes <= 121);
  }
}

TEST_CASE("waiting by reading the clock takes as long as the clock says") {
  // 31 ticks of 32.768 ms on and 31 off: a change each 1.02 s, so 57 to 59 in a minute; no wait ends early (magenta).
  SwarmProgram run("style_busy_clock");
  run.options.robots = 10;
  bool early = false;
  run.for_seconds(60, [&](const hal::PoseFrame& frame) { early = early || share(frame, Led::magenta) > 0; });
  CHECK_FALSE(early);
  for (const std::uint32_t changes : run.report.colour_changes()) {
    CHECK(changes >= 54);
    CHECK(changes <= 60);
  }
}

TEST_CASE("a robot sends once in 16 ticks") {
  // Alone, a robot that always has something to say sends 60 / (16 x 0.032768 s) = 114 times a minute.
  SwarmProgram run("count_sends");
  run.options.robots = 1;
  run.for_seconds(60);
  CHECK(run.count("infrared.sent") >= 113);
  CHECK(run.count("infrared.sent") <= 115);
}

TEST_CASE("composite messages of an arena reach the robots they name") {
  // Robot 5 is told to be blue for 100 ticks, robot 7 to be green: they are, for 3.3 s, and nobody else is.
  SwarmProgram run("ark_blocks");
  run.for_seconds(2);
  const std::vector<hal::ToRobot> told = {{.robot = 5, .slot = 0, .kind = 4, .value = 100},
                                          {.robot = 7, .slot = 0, .kind = 2, .value = 100}};
  run.swarm->arena().robots().offer(told);
  run.for_seconds(2);
  for (std::size_t i = 0; i < 25; ++i) CHECK(run.robot(i).led == (i == 5 ? Led::blue : i == 7 ? Led::green : Led::off));
  run.for_seconds(4);
  CHECK(share(run.report.last(), Led::off) == 1);
}

TEST_CASE("players of the naming game come to agree") {
  // After ten minutes all 25 say the same word.
  SwarmProgram run = crowd("naming_game");
  run.for_seconds(600);
  REQUIRE_MESSAGE(run.failure.empty(), run.failure);
  const Led word = run.robot(0).led;
  CHECK(word != Led::off);
  CHECK(share(run.report.last(), word) == 1);
}
