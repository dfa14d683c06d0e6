// Simulated Thymios beside those of Enki, the physics that Aseba's playground uses: straight, turn, wall, push.
#include <enki/PhysicalEngine.h>
#include <enki/robots/thymio2/Thymio2.h>

#include <cmath>

#include "hal/robot/set_point.hpp"
#include "hal/robot/thymio.hpp"
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

}  // namespace arkmesh::sim_ode
