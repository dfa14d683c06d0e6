// What a swarm must do whatever the details of the models, where it matters where robots begin: each test places those
// of one program.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numbers>

#include "tests/sim_ode/host/program_run.hpp"
#include "tests/support/processes/thorough.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;
using hal::Led;

namespace {

constexpr double robot_m = 0.033;

std::vector<hal::Pose> grid(int columns, int rows, double spacing_m) {
  std::vector<hal::Pose> places;
  for (int y = 0; y < rows; ++y)
    for (const hal::Pose& place :
         row(columns, spacing_m, -(columns - 1) * spacing_m / 2, (y - (rows - 1) / 2.0) * spacing_m))
      places.push_back(
          {place.x_m, place.y_m, std::remainder(static_cast<double>(places.size()) * 2.4, 2 * std::numbers::pi)});
  return places;
}

double part_lit(const hal::PoseFrame& frame, Led led) {
  return static_cast<double>(
             std::count_if(frame.robots.begin(), frame.robots.end(), [&](auto& robot) { return robot.led == led; })) /
         static_cast<double>(frame.robots.size());
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

}  // namespace

TEST_CASE("an orbiting robot keeps its distance band and comes round") {
  // With ordinary robots, each with motors of its own, for several seeds if thorough; centre to centre 58 mm are
  // wanted.
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    if (!thorough() && seed > 1) continue;
    CAPTURE(seed);
    SwarmProgram run("orbit_planet", {{0, 0, 0}, {0.055, 0, std::numbers::pi / 2}});
    run.options.seed = seed;
    run.for_seconds(20);
    double nearest = 1, farthest = 0, swept = 0, before = 0;
    run.for_seconds(280, [&](const hal::PoseFrame& frame) {
      const hal::Pose &star = frame.robots[0].pose, &planet = frame.robots[1].pose;
      nearest = std::min(nearest, distance_m(star, planet));
      farthest = std::max(farthest, distance_m(star, planet));
      const double angle = std::atan2(planet.y_m - star.y_m, planet.x_m - star.x_m);
      if (frame.number > 201) swept += std::remainder(angle - before, 2 * std::numbers::pi);
      before = angle;
    });
    REQUIRE_MESSAGE(run.failure.empty(), run.failure);
    MESSAGE(fmt::format("seed {}: {:.1f} to {:.1f} mm, {:.1f} rounds", seed, nearest * 1e3, farthest * 1e3,
                        swept / 2 / std::numbers::pi));
    CHECK(nearest > 0.035);
    CHECK(farthest < 0.085);
    CHECK(std::abs(swept) > std::numbers::pi);
  }
}

TEST_CASE("phototaxis arrives") {
  // Towards a lamp from as far away as each program can see it, and away from it; for several seeds if thorough.
  struct Case {
    std::string program;
    double from_m, arrives_m, ends_beyond_m;
  };
  for (const Case& c : {Case{"phototaxis_zigzag", 0.4, 0.05, 0}, {"phototaxis_hide", 0.15, 1, 0.35}})
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
      if (!thorough() && seed > 1) continue;
      SwarmProgram run(c.program, {{0.2 - c.from_m, 0, static_cast<double>(seed)}});
      run.options.light = hal::Pose{.x_m = 0.2, .y_m = 0};
      run.options.seed = seed;
      run.options.width_m = run.options.height_m = 1.4;
      double nearest = 1;
      run.for_seconds(300, [&](const hal::PoseFrame& frame) {
        nearest = std::min(nearest, distance_m(frame.robots[0].pose, *run.options.light));
      });
      const double at_end = distance_m(run.robot(0).pose, *run.options.light);
      MESSAGE(c.program, ", seed ", seed, ": as near as ", nearest, " m, at the end ", at_end, " m");
      CHECK_MESSAGE(run.failure.empty(), run.failure);
      CHECK(nearest < c.arrives_m);
      CHECK(at_end > c.ends_beyond_m);
    }
}

TEST_CASE("dispersing robots disperse") {
  // From a crowd 4 cm apart to neighbours beyond 8 cm, where the program stands still and shows green.
  SwarmProgram run("disperse_simple", grid(5, 5, 0.04));
  run.for_seconds(600);
  REQUIRE_MESSAGE(run.failure.empty(), run.failure);
  const double before = mean(sim_ode::nearest_neighbours(run.report.first())),
               after = mean(sim_ode::nearest_neighbours(run.report.last()));
  MESSAGE("nearest neighbours at ", before, " m, then at ", after, " m; ", part_lit(run.report.last(), Led::green),
          " rest");
  CHECK(before == doctest::Approx(0.04));
  CHECK(after > 0.07);
  CHECK(part_lit(run.report.last(), Led::green) > 0.3);
}

TEST_CASE("a driving robot pushes an idle one") {
  // Robot 0 drives at robot 1, which has never moved by itself, and takes it along without entering it.
  SwarmProgram run("labs_drive", {{0, 0, 0}, {0.05, 0.002, 0}});
  run.options.settings = {"ode.speed_spread=0.0", "ode.duty_spread=0.0"};
  double nearest = 1;
  run.for_seconds(20, [&](const hal::PoseFrame& frame) {
    nearest = std::min(nearest, distance_m(frame.robots[0].pose, frame.robots[1].pose));
  });
  REQUIRE_MESSAGE(run.failure.empty(), run.failure);
  const double pushed = distance_m(run.robot(1).pose, {0.05, 0.002, 0});
  MESSAGE("pushed by ", pushed, " m, as near as ", nearest, " m");
  CHECK(pushed > 0.01);
  CHECK(nearest > robot_m - 0.002);
}

TEST_CASE("a chain of pushers slows down") {
  // The longer the row of idle robots that one robot has to push, the less far it comes; still nobody is entered.
  double before = 1;
  for (const int idle : {0, 1, 3, 6}) {
    CAPTURE(idle);
    SwarmProgram run("labs_drive", row(1 + idle, robot_m + 0.0005, -0.2));
    run.options.settings = {"ode.speed_spread=0.0", "ode.duty_spread=0.0"};
    double nearest = 1;
    run.for_seconds(15, [&](const hal::PoseFrame& frame) {
      for (const double d : sim_ode::nearest_neighbours(frame)) nearest = std::min(nearest, d);
    });
    REQUIRE_MESSAGE(run.failure.empty(), run.failure);
    const double driven = distance_m(run.robot(0).pose, {-0.2, 0, 0});
    MESSAGE(idle, " idle robots ahead: driven ", driven, " m");
    CHECK(driven < before);
    CHECK(nearest > robot_m - 0.002);
    before = driven;
  }
}

TEST_CASE("messages reach as far as infrared does") {
  // Robot 0 talks: those 4 to 8 cm away flash yellow, those 20 cm away never.
  SwarmProgram run("labs_talk", {{0, 0, 0}, {0.04, 0, 0}, {0, 0.08, 0}, {0.2, 0, 0}, {0, -0.2, 0}});
  std::map<int, int> yellow;
  run.for_seconds(60, [&](const hal::PoseFrame& frame) {
    for (const hal::Observation& robot : frame.robots) yellow[robot.robot] += robot.led == Led::yellow;
  });
  CHECK(yellow[1] > 50);
  CHECK(yellow[2] > 50);
  CHECK(yellow[3] == 0);
  CHECK(yellow[4] == 0);
}

TEST_CASE("distance readings tell how far a speaker is") {
  // Pairs of robots 3.7 to 9 cm apart, far from each other, show the colour of their distance.
  const std::vector<std::pair<double, Led>> pairs = {{0.037, Led::red},  {0.045, Led::yellow}, {0.055, Led::green},
                                                     {0.065, Led::cyan}, {0.075, Led::blue},   {0.09, Led::white}};
  std::vector<hal::Pose> places;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (const double x_m : {0.0, pairs[i].first}) places.push_back({x_m, 0.25 * (static_cast<double>(i) - 2.5), 0});
  SwarmProgram run("labs_distance", places);
  run.options.height_m = 2;
  run.for_seconds(30);
  for (std::size_t i = 0; i < places.size(); ++i) CHECK(run.robot(i).led == pairs[i / 2].second);
}

TEST_CASE("what an arena tells one robot spreads among those in reach of each other") {
  // Robot 0 is told a value; two connected rows of robots pass it on, a robot far away never learns of it.
  auto places = row(8, 0.07, -0.4);
  places.push_back({0.4, 0.4, 0});
  SwarmProgram run("ark_gossip", places);
  run.for_seconds(2);
  const std::vector<hal::ToRobot> told = {{.robot = 0, .slot = 0, .kind = 1, .value = 700}};
  run.swarm->arena().robots().offer(told);
  run.for_seconds(20);
  for (std::size_t i = 0; i < 8; ++i) CHECK(run.robot(i).led == Led::green);
  CHECK(run.robot(8).led == Led::off);
}
