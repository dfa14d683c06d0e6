// Obstacles and objects: where they stop robots, who can push them, what they hide.
#include <cmath>
#include <numbers>

#include "hal/platforms/kilobot/body.hpp"
#include "sim_ode/contact_world.hpp"
#include "sim_ode/outline.hpp"
#include "tests/sim_ode/arena_builder.hpp"
#include "tests/support/processes/thorough.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double robot_r = hal::kilobot::body_radius_m;

hal::Shape box(double length_m, double width_m) {
  const double l = length_m / 2, w = width_m / 2;
  return {0, {{-l, -w}, {l, -w}, {l, w}, {-l, w}}};
}

hal::Shape disc(double radius_m) {
  return {radius_m, {}};
}

// How far a disc of 50 mm and 100 g goes in 4 s that so many robots, side by side on an arc behind it, push.
double pushed_m(int robots, double table_friction) {
  constexpr double radius = 0.05;
  hal::Solids solids;
  solids.objects.push_back({"puck", disc(radius), {0, 0, 0}, 0.1, table_friction});
  std::vector<hal::Pose> start;
  for (int i = 0; i < robots; ++i) {
    const double angle = std::numbers::pi + (i - (robots - 1) / 2.0) * 0.53, apart = radius + robot_r + 0.0002;
    start.push_back({apart * std::cos(angle), apart * std::sin(angle), 0});
  }
  ContactWorld world(2, 1, {}, 1, start, solids);
  for (int i = 0; i < robots; ++i) world.set_velocity(i, {0.01, 0, 0});
  for (int k = 0; k < 122; ++k) world.tick();
  std::vector<hal::ObjectObservation> seen;
  world.solids().poses(1, seen);
  const double went = seen[0].pose.x_m;
  CHECK(world.totals().deepest_m < 0.0005);
  CHECK(world.totals().drift_m < 1e-9);
  // without robots' drive it rests, momentum gone, where the table has friction
  for (int i = 0; i < robots; ++i) world.set_velocity(i, {});
  for (int k = 0; k < 3; ++k) world.tick();
  seen.clear();
  world.solids().poses(1, seen);
  const double rest = seen[0].pose.x_m;
  world.tick();
  seen.clear();
  world.solids().poses(1, seen);
  if (table_friction > 0) CHECK(seen[0].pose.x_m == rest);
  return went;
}

// At any speed, mass and friction that keys allow: robots, obstacles of all kinds and objects keep out of each other.
void check_random_arenas(int arenas) {
  hal::RandomStream chance(1, "solids");
  double deepest = 0;
  for (int k = 0; k < arenas; ++k) {
    CAPTURE(k);
    hal::Solids solids;
    solids.obstacles.push_back({box(0.15, 0.01), {0.1, 0, chance.uniform(0, 3)}});
    solids.obstacles.push_back({disc(0.03), {-0.1, 0.12, 0}});
    solids.obstacles.push_back(
        {{0, {{0, 0}, {0.1, 0}, {0.1, 0.02}, {0.02, 0.02}, {0.02, 0.1}, {0, 0.1}}}, {-0.22, -0.22, 0}});
    solids.objects.push_back({"a",
                              box(0.05, 0.03),
                              {0, -0.12, chance.uniform(0, 3)},
                              std::pow(10, chance.uniform(-3, 1)),
                              chance.uniform(0, 1)});
    solids.objects.push_back(
        {"b", disc(0.02), {-0.05, 0.03, 0}, std::pow(10, chance.uniform(-3, 1)), chance.uniform(0, 1)});
    std::vector<hal::Pose> start;
    for (int i = 0; i < 6; ++i) start.push_back({-0.2 + 0.05 * i, 0.2, 6.28 * chance.uniform()});
    for (int i = 0; i < 5; ++i) start.push_back({-0.1 + 0.05 * i, -0.2, 6.28 * chance.uniform()});
    const double fastest = std::pow(10, chance.uniform(-2.5, -0.5)), turn = chance.uniform(0, 9);
    ContactWorld world(
        0.5, 0.5,
        {.solver = k % 2 ? Solver::ode : Solver::fast, .friction = chance.uniform(0, 2), .speed_m_s = fastest}, 1,
        start, solids);
    for (int tick = 0; tick < 60; ++tick) {
      for (int i = 0; i < world.robots(); ++i)
        if (tick % 20 == 0) world.set_velocity(i, {chance.uniform(0, fastest), 0, chance.uniform(-turn, turn)});
      world.tick();
    }
    CHECK(world.totals().deepest_m < 0.0005);
    deepest = std::max(deepest, world.totals().deepest_m);
    // the middle of each robot is outside of everything
    for (int i = 0; i < world.robots(); ++i)
      CHECK(world.solids().clearance_m(world.x()[static_cast<std::size_t>(i)], world.y()[static_cast<std::size_t>(i)],
                                       1) > robot_r - 0.001);
  }
  MESSAGE("deepest " << deepest * 1000 << " mm");
}

}  // namespace

TEST_CASE("outlines") {
  // A box, its corners, a dent: where others touch, and how far away.
  const Outline square(box(0.2, 0.1));
  CHECK(square.distance_m(0.15, 0) == doctest::Approx(0.05));
  CHECK(square.distance_m(0, 0.04) == doctest::Approx(-0.01));
  CHECK(square.distance_m(0.13, 0.09) == doctest::Approx(0.05));
  std::vector<Outline::Touch> touches;
  square.touches(0.13, 0.09, 0.0495, 0.001, touches);
  REQUIRE(touches.size() == 1);
  CHECK(touches[0].gap_m == doctest::Approx(0.0005));
  CHECK(touches[0].normal_x == doctest::Approx(0.6));
  CHECK(touches[0].x == doctest::Approx(0.1));
  CHECK(square.gyration_m2() == doctest::Approx((0.04 + 0.01) / 12));
  CHECK_FALSE(Outline({0, {{0, 0}, {0.2, 0}, {0.2, 0.2}, {0.1, 0.1}, {0, 0.2}}}).is_convex());

  // an L: both inner sides touch at once
  const Outline corner({0, {{0, 0}, {0.2, 0}, {0.2, 0.05}, {0.05, 0.05}, {0.05, 0.2}, {0, 0.2}}});
  touches.clear();
  corner.touches(0.07, 0.07, 0.0195, 0.001, touches);
  REQUIRE(touches.size() == 2);
  for (const Outline::Touch& touch : touches) CHECK(touch.gap_m == doctest::Approx(0.0005));
  CHECK(Outline(disc(0.03)).mean_distance_m() == doctest::Approx(0.02));
  CHECK(square.mean_distance_m() == doctest::Approx(0.0593).epsilon(0.01));  // of a rectangle of 2 to 1
}

TEST_CASE("an object moves when enough robots push") {
  // 100 g with a friction of 0.1 resist with 0.098 N. A robot pushes with 0.04 N, less where it comes from the side.
  CHECK(pushed_m(1, 0.1) == 0);
  CHECK(pushed_m(2, 0.1) == 0);
  const double eight = pushed_m(8, 0.1);
  CHECK(eight > 0.005);
  CHECK(eight < 0.04);
  CHECK(pushed_m(1, 0) > 0.02);
}

TEST_CASE("a box stays in the plane, in the arena and whole") {
  // Pushed into a corner and beyond, it turns and rests against walls, not inside.
  hal::Solids solids;
  solids.objects.push_back({"crate", box(0.12, 0.06), {0.3, 0.1, 0.4}, 0.05, 0.1});
  std::vector<hal::Pose> start;
  for (int i = 0; i < 6; ++i) start.push_back({0.15, 0.02 + 0.034 * i, 0.1});
  ContactWorld world(1, 0.6, {}, 1, start, solids);
  for (int i = 0; i < 6; ++i) world.set_velocity(i, {0.01, 0, 0});
  for (int k = 0; k < 1200; ++k) world.tick();
  std::vector<hal::ObjectObservation> seen;
  world.solids().poses(1, seen);
  CHECK(seen[0].pose.x_m > 0.4);
  const Outline outline(box(0.12, 0.06));
  const PlacedOutline placed = place(outline, seen[0].pose);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(std::abs(placed.corner(i).x_m) < 0.5 + 0.0005);
    CHECK(std::abs(placed.corner(i).y_m) < 0.3 + 0.0005);
  }
  CHECK(world.totals().deepest_m < 0.0005);
}

TEST_CASE("nothing passes through anything") {
  check_random_arenas(60);
}

TEST_CASE("nothing passes through anything, in a thousand arenas" * doctest::skip(!arkmesh::tests::thorough())) {
  check_random_arenas(1000);
}

TEST_CASE("an arena with obstacles and objects") {
  // Config places them; frames tell where objects are; the same seed gives the same run; robots start clear of them.
  const TestArena scene{
      .program = "wander.c",
      .robots = 20,
      .side_m = 0.5,
      .arena =
          "obstacles = [{shape = \"disc\", x_m = 0.1, radius_m = 0.05},"
          " {shape = \"wall\", x_m = -0.1, length_m = 0.2, heading_deg = 90}]\n"
          "objects = [{name = \"puck\", shape = \"disc\", radius_m = 0.03, y_m = 0.15, mass_kg = 0.01}]"};
  auto arena = scene.make_running(), again = scene.make_running();
  CHECK(arena->info().obstacles.size() == 2);
  REQUIRE(arena->info().objects.size() == 1);
  CHECK(arena->info().objects[0].name == "puck");
  double moved = 0;
  for (int k = 0; k <= 600; ++k) {
    const hal::PoseFrame frame = frame_at(*arena, seconds(0.1 * k)), same = frame_at(*again, seconds(0.1 * k));
    REQUIRE(frame.objects.size() == 1);
    CHECK(frame.objects[0].pose.x_m == same.objects[0].pose.x_m);
    moved = std::max(moved, std::abs(frame.objects[0].pose.x_m));
    for (const hal::Observation& robot : frame.robots) {
      CHECK(std::hypot(robot.pose.x_m - 0.1, robot.pose.y_m) > 0.05 + robot_r - 0.001);
      CHECK(std::hypot(robot.pose.x_m - frame.objects[0].pose.x_m, robot.pose.y_m - frame.objects[0].pose.y_m) >
            0.03 + robot_r - 0.001);
    }
  }
  CHECK(moved > 0);
  CHECK(arena->counters()["contacts.deeper_than_1mm"] == 0);
}

TEST_CASE("impossible obstacles and objects") {
  const auto says = [](const std::string& keys) {
    try {
      TestArena{.robots = 1, .side_m = 0.5, .ode = "start_poses = [0, 0, 0]", .arena = keys}.make();
    } catch (const hal::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  for (const auto& row : {
           std::pair("obstacles = [{shape = \"disc\"}]", "radius_m"),
           std::pair("obstacles = [{shape = \"disc\", radius_m = 0.1, length_m = 1}]", "does not belong"),
           std::pair("obstacles = [{shape = \"polygon\", corners = [0, 0, 1, 0, 0]}]", "x and y of 3"),
           std::pair("obstacles = [{shape = \"polygon\", corners = [0, 0, 1, 1, 1, 0, 0, 1]}]", "crosses itself"),
           std::pair("obstacles = [{shape = \"disc\", radius_m = 0.1}]", "an obstacle or an object is"),
           std::pair("objects = [{shape = \"disc\", radius_m = 0.1}]", "name"),
           std::pair("objects = [{name = \"a\", shape = \"disc\", radius_m = 0.1, x_m = 0.2}]", "inside the walls"),
           std::pair("objects = [{name = \"a\", shape = \"disc\", radius_m = 0.02, x_m = 0.1},"
                     " {name = \"a\", shape = \"disc\", radius_m = 0.02, x_m = -0.1}]",
                     "must be unique"),
           std::pair("objects = [{name = \"a\", shape = \"disc\", radius_m = 0.02, x_m = 0.1},"
                     " {name = \"b\", shape = \"disc\", radius_m = 0.02, x_m = 0.11}]",
                     "overlap"),
       }) {
    const std::string said = says(row.first);
    CAPTURE(row.first);
    CAPTURE(said);
    CHECK(said.find(row.second) != std::string::npos);
  }
}

TEST_CASE("obstacles stop infrared") {
  // Two robots that chat hear nothing of each other through a wall.
  for (const bool wall : {false, true}) {
    const TestArena scene{.program = "chatter.c",
                          .robots = 2,
                          .side_m = 0.5,
                          .ode = "start_poses = [-0.03, 0, 0, 0.03, 0, 0]",
                          .arena = wall ? "obstacles = [{shape = \"wall\", length_m = 0.1, heading_deg = 90}]" : ""};
    auto arena = scene.make_running();
    arena->advance_to(seconds(10));
    CHECK((arena->counters()["infrared.received"] > 0) == !wall);
  }
}

}  // namespace arkmesh::sim_ode
