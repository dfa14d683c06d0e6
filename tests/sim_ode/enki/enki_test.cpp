// Simulated Thymios beside those of Enki, the physics that Aseba's playground uses: straight, turn, wall, push,
// proximity.
#include <enki/PhysicalEngine.h>
#include <enki/robots/thymio2/Thymio2.h>

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "hal/robot/set_point.hpp"
#include "hal/robot/thymio.hpp"
#include "sim_ode/simulated_arena.hpp"
#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {
namespace {

// Where the axle's middle is, how far it has turned, and how far what it pushes has come; metres.
struct Ride {
  double x_m = 0, turned_rad = 0, pushed_m = 0;
};

// A Thymio with its axle 1 m from the east wall of 2 m x 2 m and, on request, another robot 15 cm ahead or a box 10 cm
// wide, ridden for so long.
enum class Ahead { nothing, robot, box };
constexpr double side_m = 2, robot_ahead_m = 0.15, box_ahead_m = 0.14, box_side_m = 0.1;

Ride by_enki(double left_m_s, double right_m_s, double run_s, Ahead ahead) {
  Enki::World world(100 * side_m, 100 * side_m);  // centimetres
  auto* const robot = new Enki::Thymio2;
  robot->pos = Enki::Point(100, 100);
  robot->angle = 0;
  world.addObject(robot);
  Enki::PhysicalObject* pushed = nullptr;
  if (ahead == Ahead::robot) pushed = new Enki::Thymio2;
  if (ahead == Ahead::box) {
    pushed = new Enki::PhysicalObject;
    pushed->setRectangular(100 * box_side_m, 100 * box_side_m, 5, 50);
    pushed->dryFrictionCoefficient = 0.5;
  }
  if (pushed) {
    pushed->pos = Enki::Point(100 + 100 * (ahead == Ahead::robot ? robot_ahead_m : box_ahead_m), 100);
    pushed->angle = 0;
    world.addObject(pushed);
  }
  robot->leftSpeed = 100 * left_m_s;
  robot->rightSpeed = 100 * right_m_s;
  Ride out;
  const double from = pushed ? pushed->pos.x : 0;
  for (double t = 0; t < run_s - 1e-9; t += 0.01) {
    const double before = robot->angle;
    world.step(0.01, 3);
    out.turned_rad += std::remainder(robot->angle - before, 2 * 3.14159265358979);
  }
  out.x_m = robot->pos.x / 100 - 1;
  if (pushed) out.pushed_m = (pushed->pos.x - from) / 100;
  return out;
}

Ride by_us(double left_m_s, double right_m_s, double run_s, Ahead ahead) {
  const double behind_m = hal::thymio().drive.axle_behind_m;
  std::string text =
      fmt::format("[arena]\nwidth_m = {0}\nheight_m = {0}\nrobots = {1}\n", side_m, ahead == Ahead::robot ? 2 : 1);
  if (ahead == Ahead::box)
    text += fmt::format(
        "objects = [{{name = \"box\", shape = \"box\", x_m = {}, y_m = 0.0, length_m = {}, width_m = {}, "
        "mass_kg = 0.05, friction = 0.5}}]\n",
        box_ahead_m, box_side_m, box_side_m);
  text += fmt::format("[arena.ode]\nrobot = \"thymio\"\nstart_poses = [{}, 0, 0{}]\n", behind_m,
                      ahead == Ahead::robot ? fmt::format(", {}, 0, 0", behind_m + robot_ahead_m) : "");
  const auto config = hal::Config::from_text(text, "enki.toml");
  const auto arena = make_ode_arena(config.root().section("arena"), "b", 1);
  arena->robots().command({.kind = hal::FleetCommand::Kind::run});
  frame_at(*arena, seconds(1));
  const auto set = [&](double left, double right) {
    const std::vector<hal::ToRobot> words{hal::to_robot(
        0, hal::SetPoint{static_cast<int>(std::lround(1000 * left)), static_cast<int>(std::lround(1000 * right))})};
    arena->robots().offer(words);
  };
  set(left_m_s, right_m_s);
  Ride out;
  hal::PoseFrame frame;
  double heading = 0;
  const int frames = static_cast<int>(std::lround(10 * run_s));
  for (int k = 1; k <= frames + 1; ++k) {
    if (k == frames) set(0, 0);  // as late as the first words
    frame = frame_at(*arena, seconds(1 + 0.1 * k));
    out.turned_rad += std::remainder(frame.robots[0].pose.heading_rad - heading, 2 * 3.14159265358979);
    heading = frame.robots[0].pose.heading_rad;
  }
  out.x_m = frame.robots[0].pose.x_m - behind_m * std::cos(heading);
  if (ahead == Ahead::robot) out.pushed_m = frame.robots[1].pose.x_m - behind_m - robot_ahead_m;
  if (ahead == Ahead::box) out.pushed_m = frame.objects.at(0).pose.x_m - box_ahead_m;
  return out;
}

// Proximity sensors of a Thymio at a pose of its axle in that arena, beside another robot's or nobody.
using Readings = std::array<double, 7>;

Readings seen_by_enki(const hal::Pose& axle, const std::optional<hal::Pose>& other) {
  Enki::World world(100 * side_m, 100 * side_m);
  auto* const robot = new Enki::Thymio2;
  const auto put = [&](Enki::PhysicalObject* object, const hal::Pose& at) {
    object->pos = Enki::Point(100 * (at.x_m + side_m / 2), 100 * (at.y_m + side_m / 2));
    object->angle = at.heading_rad;
    world.addObject(object);
  };
  put(robot, axle);
  if (other) put(new Enki::Thymio2, *other);
  Readings out{};
  constexpr int times = 30;  // its readings are noisy
  for (int i = 0; i < times; ++i) {
    world.step(1e-6, 1);
    const Enki::IRSensor* const sensors[] = {&robot->infraredSensor0, &robot->infraredSensor1, &robot->infraredSensor2,
                                             &robot->infraredSensor3, &robot->infraredSensor4, &robot->infraredSensor5,
                                             &robot->infraredSensor6};
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += sensors[k]->getValue() / times;
  }
  return out;
}

Readings seen_by_us(const hal::Pose& axle, const std::optional<hal::Pose>& other) {
  const auto start = [](const hal::Pose& at) {
    const double ahead_m = hal::thymio().drive.axle_behind_m;
    return fmt::format("{}, {}, {}", at.x_m + ahead_m * std::cos(at.heading_rad),
                       at.y_m + ahead_m * std::sin(at.heading_rad), at.heading_rad);
  };
  const auto config = hal::Config::from_text(
      fmt::format("[arena]\nwidth_m = {0}\nheight_m = {0}\nrobots = {1}\n[arena.ode]\nrobot = \"thymio\"\n"
                  "start_poses = [{2}{3}{4}]\n",
                  side_m, other ? 2 : 1, start(axle), other ? ", " : "", other ? start(*other) : ""),
      "enki.toml");
  const auto arena = make_simulated_arena(config.root().section("arena"), "b", 1, {});
  Readings out{};
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = arena->prox(0, static_cast<int>(k)).value();
  return out;
}

}  // namespace

TEST_CASE("thymio: as Enki's") {
  // Within five in a hundred of another simulator of the same robot.
  constexpr double near = 0.05;
  const auto nothing = Ahead::nothing;
  CHECK(by_us(0.1, 0.1, 4, nothing).x_m == doctest::Approx(by_enki(0.1, 0.1, 4, nothing).x_m).epsilon(near));
  CHECK(by_us(-0.05, 0.05, 4, nothing).turned_rad ==
        doctest::Approx(by_enki(-0.05, 0.05, 4, nothing).turned_rad).epsilon(near));
  CHECK(by_us(0.05, 0.1, 4, nothing).turned_rad ==
        doctest::Approx(by_enki(0.05, 0.1, 4, nothing).turned_rad).epsilon(near));
  // at the wall: what is left of the way
  const double ours = side_m / 2 - by_us(0.1, 0.1, 12, nothing).x_m,
               theirs = side_m / 2 - by_enki(0.1, 0.1, 12, nothing).x_m;
  CHECK(ours == doctest::Approx(theirs).epsilon(near));
  for (const Ahead ahead : {Ahead::robot, Ahead::box}) {
    CAPTURE(static_cast<int>(ahead));
    const Ride us = by_us(0.06, 0.06, 4, ahead), enki = by_enki(0.06, 0.06, 4, ahead);
    CHECK(us.x_m == doctest::Approx(enki.x_m).epsilon(near));
    CHECK(us.pushed_m == doctest::Approx(enki.pushed_m).epsilon(near));
  }
}

TEST_CASE("thymio: proximity as Enki's") {
  // A wall ahead, aslant, beside and behind reads as in Enki within 2 % of the greatest reading.
  constexpr double greatest = 4505;
  const auto judge = [&](const hal::Pose& axle, const std::optional<hal::Pose>& other, double near) {
    CAPTURE(axle.x_m);
    CAPTURE(axle.heading_rad);
    const Readings ours = seen_by_us(axle, other), theirs = seen_by_enki(axle, other);
    double most = 0;
    for (std::size_t k = 0; k < ours.size(); ++k) {
      CAPTURE(k);
      CAPTURE(ours[k]);
      CAPTURE(theirs[k]);
      CHECK(std::abs(ours[k] - theirs[k]) < near * greatest);
      most = std::max(most, ours[k]);
    }
    return most;
  };
  for (const double gap_m : {0.09, 0.11, 0.14, 0.18, 0.20})
    for (int turn = -6; turn <= 6; ++turn)
      CHECK(judge({side_m / 2 - gap_m, 0.1, turn * std::numbers::pi / 6 + 0.01}, {}, 0.02) >= 0);
  CHECK(judge({side_m / 2 - 0.09, 0, 0}, {}, 0.02) > 4000);
  CHECK(judge({side_m / 2 - 0.25, 0, 0}, {}, 0.02) == 0);
  // in a corner, and another robot's front ahead, which is as round as a disc
  judge({0.88, 0.9, 0.6}, {}, 0.02);
  for (const double ahead_m : {0.18, 0.22, 0.26})
    CHECK(judge({0, 0, 0}, hal::Pose{ahead_m, 0, std::numbers::pi}, 0.05) > 1000);
}

}  // namespace arkmesh::sim_ode
