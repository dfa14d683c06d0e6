// Where robots stand at the beginning.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {

TEST_CASE("places by hand") {
  // Robots stand where start_poses puts them, ids in order; touching each other and the wall is allowed.
  auto arena =
      TestArena{.robots = 3, .ode = "start_poses = [0.1, -0.2, 1.5, 0.133, -0.2, -3, 0.4835, 0.4835, 0]"}.make();
  const hal::PoseFrame frame = frame_at(*arena, hal::LabTime{0});
  CHECK(frame.robots[0].pose.x_m == 0.1);
  CHECK(frame.robots[0].pose.y_m == -0.2);
  CHECK(frame.robots[0].pose.heading_rad == doctest::Approx(1.5));
  CHECK(frame.robots[1].pose.x_m == 0.133);
  CHECK(frame.robots[1].pose.heading_rad == doctest::Approx(-3));
  CHECK(frame.robots[2].pose.y_m == 0.4835);
}

TEST_CASE("impossible places") {
  // A wrong count, a place in the wall and overlapping robots are refused by name.
  const auto refusal = [](const char* poses) {
    try {
      TestArena{.robots = 2, .ode = std::string("start_poses = ") + poses}.make();
    } catch (const hal::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refusal("[0, 0, 0, 0.2, 0, 0]") == "accepted");
  CHECK(refusal("[0, 0, 0]").find("holds 1 place for 2 robots") != std::string::npos);
  CHECK(refusal("[0, 0, 0, 0.2]").find("three numbers for each robot") != std::string::npos);
  CHECK(refusal("[0, 0, 0, 0.2, 0.49, 0]").find("robot 1 at 0.2, 0.49, not completely inside the walls") !=
        std::string::npos);
  CHECK(refusal("[0, 0, 0, 0.03, 0, 0]").find("robots 0 and 1 closer than 0.033 m") != std::string::npos);
  CHECK(refusal("[0, 0, 0, nan, 0, 0]") != "accepted");
}

namespace {

std::vector<hal::Pose> start_of(const TestArena& arena) {
  std::vector<hal::Pose> out;
  for (const hal::Observation& robot : frame_at(*arena.make(), hal::LabTime{0}).robots) out.push_back(robot.pose);
  return out;
}

double nearest_m(const std::vector<hal::Pose>& poses) {
  double nearest = 1e9;
  for (std::size_t i = 0; i < poses.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      nearest = std::min(nearest, std::hypot(poses[i].x_m - poses[j].x_m, poses[i].y_m - poses[j].y_m));
  return nearest;
}

}  // namespace

TEST_CASE("start regions") {
  // A box, disc, ring or grid holds all robots, apart from each other, as run.seed has it; what reaches beyond a wall
  // or into an obstacle is left free.
  struct Region {
    const char* keys;
    std::function<bool(double x, double y)> holds;
  };
  const Region regions[] = {
      {R"(start = "box"
start_at = [0.2, -0.1, 0.4, 0.3])",
       [](double x, double y) { return std::abs(x - 0.2) <= 0.2 && std::abs(y + 0.1) <= 0.15; }},
      {R"(start = "disc"
start_at = [0.1, 0.1, 0.2])",
       [](double x, double y) { return std::hypot(x - 0.1, y - 0.1) <= 0.2 + 1e-12; }},
      {R"(start = "ring"
start_at = [0, 0, 0.3, 0.32])",
       [](double x, double y) { return std::abs(std::hypot(x, y) - 0.31) <= 0.01 + 1e-12; }},
      // more than two thirds of it beyond the walls
      {R"(start = "disc"
start_at = [0.5, 0.5, 0.4])",
       [](double x, double y) { return std::hypot(x - 0.5, y - 0.5) <= 0.4 && x <= 0.4836 && y <= 0.4836; }},
      {R"(start = "grid"
start_at = [0.1, 0, 0.05])",
       [](double x, double y) {
         const double column = (x - 0.1) / 0.05 + 0.5, row = y / 0.05 + 0.5;
         return std::abs(column - std::round(column)) < 1e-9 && std::abs(row - std::round(row)) < 1e-9;
       }}};
  for (const Region& region : regions) {
    CAPTURE(region.keys);
    const auto start = start_of({.robots = 16, .ode = region.keys}),
               again = start_of({.robots = 16, .ode = region.keys}),
               other = start_of({.robots = 16, .ode = region.keys, .seed = 2});
    for (const hal::Pose& pose : start) CHECK(region.holds(pose.x_m, pose.y_m));
    CHECK(nearest_m(start) >= 0.034 - 1e-12);
    CHECK(start[3].x_m == again[3].x_m);
    CHECK(start[3].heading_rad != other[3].heading_rad);
  }
  // so dense that robots stand on a grid of places
  CHECK(nearest_m(start_of({.robots = 60, .ode = "start = \"box\"\nstart_at = [0.2, 0.2, 0.3, 0.3]"})) >=
        0.034 - 1e-12);
}

TEST_CASE("groups start where each of them says, and keep clear of places by hand") {
  const auto start = start_of({.robots = 13, .ode = R"(start = "disc"
start_at = [0, 0, 0.1]
[[arena.ode.group]]
robots = 4
start = "grid"
start_at = [-0.4, -0.4, 0.05]
[[arena.ode.group]]
robots = 4
start = "ring"
start_at = [0, 0, 0.06, 0.1]
[[arena.ode.group]]
robots = 1
start_poses = [0, 0, 0])"});
  for (std::size_t i = 0; i < 4; ++i) CHECK(std::hypot(start[i].x_m + 0.4, start[i].y_m + 0.4) < 0.05);
  for (std::size_t i = 4; i < 13; ++i) CHECK(std::hypot(start[i].x_m, start[i].y_m) <= 0.1);
  for (std::size_t i = 4; i < 8; ++i) CHECK(std::hypot(start[i].x_m, start[i].y_m) >= 0.06);
  CHECK(start[8].x_m == 0);
  CHECK(nearest_m(start) >= 0.034 - 1e-12);
}

TEST_CASE("start regions that cannot be are refused by name") {
  const auto refusal = [](const std::string& keys, int robots = 3) {
    try {
      TestArena{.robots = robots, .ode = keys}.make();
    } catch (const hal::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refusal("start = \"box\"").find("start_at = []: must hold x, y, width, height") != std::string::npos);
  CHECK(refusal("start = \"ring\"\nstart_at = [0, 0, 0.3, 0.2]").find("inner and outer radius") != std::string::npos);
  CHECK(refusal("start = \"disc\"\nstart_at = [0, 0, -1]").find("radius of the disc") != std::string::npos);
  CHECK(refusal("start_at = [0, 0, 0.3]").find("belongs to start = ") != std::string::npos);
  CHECK(refusal("start = \"disc\"\nstart_at = [0, 0, 0.02]").find("has no room for 3 robots") != std::string::npos);
  CHECK(refusal("start = \"disc\"\nstart_at = [3, 0, 1]").find("has no room") != std::string::npos);
  CHECK(refusal("start = \"grid\"\nstart_at = [0, 0, 0.03]").find("has no room") != std::string::npos);
  CHECK(refusal("start = \"grid\"\nstart_at = [0, 0.49, 0.05]").find("has no room") != std::string::npos);
}

TEST_CASE("round and polygonal arenas") {
  // Robots start and stay inside, touch the walls, and can be put nowhere else; lamps outside shine in.
  const auto outside = [](const hal::Pose& p) { return std::hypot(p.x_m, p.y_m) > 0.2 - 0.0165 + 1e-6; };
  const TestArena round{.program = "all_ahead.c", .robots = 30, .side_m = 0.4, .arena = "shape = \"round\""};
  for (const hal::Pose& pose : start_of(round)) CHECK_FALSE(outside(pose));
  auto arena = round.make_running();
  int at_walls = 0;
  for (const hal::Observation& robot : frame_at(*arena, seconds(60)).robots) {
    CHECK_FALSE(outside(robot.pose));
    at_walls += std::hypot(robot.pose.x_m, robot.pose.y_m) > 0.2 - 0.0165 - 0.002;
  }
  CHECK(at_walls > 5);
  const std::string corner = "shape = \"polygon\"\ncorners = [-0.2, -0.2, 0.2, -0.2, 0.2, 0, 0, 0, 0, 0.2, -0.2, 0.2]";
  const TestArena dented{.program = "all_ahead.c", .robots = 20, .side_m = 0.4, .arena = corner};
  auto bent = dented.make_running();
  for (const hal::PoseFrame& frame : {frame_at(*bent, hal::LabTime{0}), frame_at(*bent, seconds(60))})
    for (const hal::Observation& robot : frame.robots)
      CHECK_FALSE((robot.pose.x_m > -0.0165 + 1e-6 && robot.pose.y_m > -0.0165 + 1e-6));
  const auto refusal = [](const std::string& keys, double side_m = 0.4) {
    try {
      TestArena{.robots = 1, .side_m = side_m, .arena = keys}.make();
    } catch (const hal::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refusal("shape = \"polygon\"").find("must hold x and y of 3 to 64 corners") != std::string::npos);
  CHECK(refusal("corners = [0, 0, 1, 0, 1, 1]").find("belong to shape = \"polygon\"") != std::string::npos);
  CHECK(refusal(corner, 0.3).find("must lie within width_m x height_m") != std::string::npos);
  CHECK(refusal("shape = \"oval\"").find("arena.shape") != std::string::npos);
}

}  // namespace arkmesh::sim_ode
