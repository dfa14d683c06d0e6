// Calibration of the motors of simulated robots that run calibrate_motors.c.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "hal/platforms/kilobot/body.hpp"
#include "tests/tracker/identity/arena_swarm.hpp"
#include "tracker/identity/motor_calibrator.hpp"

using namespace arkmesh;
using tests::ArenaSwarm;
using tracker::MotorCalibrator;

namespace {

constexpr const char* calibrate_motors_c = "hal/platforms/kilobot/firmware/calibrate_motors.c";
constexpr double degree = std::numbers::pi / 180;

void run(ArenaSwarm& swarm, MotorCalibrator& calibrator, double max_s) {
  while (!calibrator.finished() && swarm.seconds() < max_s) {
    const auto& tracks = swarm.next_picture(calibrator.question());
    hal::PoseFrame frame{.stamp = swarm.now};
    for (const tracker::Track& track : tracks)
      frame.robots.push_back({.robot = swarm.ids[swarm.robot_of(track.number)],
                              .pose = track.in_arena,
                              .led = track.led,
                              .age = track.age});
    std::sort(frame.robots.begin(), frame.robots.end(), [](const auto& a, const auto& b) { return a.robot < b.robot; });
    calibrator.on_frame(frame);
    swarm.arena().robots().offer(calibrator.take_messages());
  }
  CHECK(calibrator.finished());
}

std::vector<hal::RobotId> numbers(std::size_t n) {
  std::vector<hal::RobotId> out(n);
  std::iota(out.begin(), out.end(), 0u);
  return out;
}

// What a robot does when it is told so after calibration: speed ahead and turning rate.
struct Motion {
  double speed_m_s, turn_rad_s;
};
Motion measured(ArenaSwarm& swarm, std::uint16_t id, std::uint8_t kind, int left, int right, double s) {
  const std::size_t robot = swarm.robot_with(id);
  REQUIRE(swarm.arena().put(static_cast<int>(robot), {-0.1, 0, 0}) == "");
  std::vector<hal::ToRobot> messages = {
      {.robot = id, .slot = 1, .kind = 5, .value = static_cast<std::uint16_t>(right)},
      {.robot = id, .slot = 0, .kind = kind, .value = static_cast<std::uint16_t>(left)}};
  for (int i = 0; i < 8; ++i) {
    swarm.arena().robots().offer(messages);
    swarm.next_picture({});
  }
  const hal::Pose begin = swarm.seen(robot).pose;
  double turned = 0, heading = begin.heading_rad;
  const double begun_s = swarm.seconds();
  while (swarm.seconds() - begun_s < s - 0.05) {
    swarm.next_picture({});
    turned += std::remainder(swarm.seen(robot).pose.heading_rad - heading, 2 * std::numbers::pi);
    heading = swarm.seen(robot).pose.heading_rad;
  }
  const hal::Pose end = swarm.seen(robot).pose;
  return {std::hypot(end.x_m - begin.x_m, end.y_m - begin.y_m) / s, turned / s};
}

}  // namespace

TEST_CASE("identity calibration: twelve unequal robots turn and go straight alike") {
  // Of motors that differ by a fifth, seen with a millimetre of noise, a tenth of the messages lost: each gets duties
  // with which it, looked at by itself, turns 32 to 47 degrees a second to both sides and goes 8.5 to 15 mm/s on a
  // course that turns less than 4 degrees a second. (The slowest path that passes as a turn, 10.5 mm/s, is 35 degrees a
  // second on an arc of 17 mm.)
  ArenaSwarm swarm({.program = calibrate_motors_c,
                    .robots = 12,
                    .side_m = 1.5,
                    .ode = "overhead_loss = 0.1",
                    .position_noise_m = 0.0007});
  swarm.run();
  MotorCalibrator calibrator({.width_m = 1.5, .height_m = 1.5, .body_radius_m = hal::kilobot::body_radius_m},
                             numbers(12));
  run(swarm, calibrator, 1800);
  MESSAGE("12 robots calibrated in ", swarm.seconds(), " s, ", calibrator.counters()["calibration.changed"],
          " changes, ", calibrator.counters()["calibration.repeated.contact"], " pictures with contacts");
  for (const auto& entry : calibrator.robots()) {
    const auto& [id, robot] = entry;
    INFO("robot ", entry.first, ": ", entry.second.why);
    CHECK(robot.stage == MotorCalibrator::Stage::done);
    CHECK(robot.stored);
    CHECK(robot.round);
    const auto number = static_cast<std::uint16_t>(id);
    // clear the middle, one at a time
    for (std::uint16_t other = 0; other < 12; ++other)
      swarm.arena().take_off(static_cast<int>(swarm.robot_with(other)));
    const auto& duties = robot.duties;
    const Motion left = measured(swarm, number, 1, duties.turn_left, duties.straight_right, 6);
    const Motion right = measured(swarm, number, 2, duties.turn_right, duties.straight_right, 6);
    const Motion ahead = measured(swarm, number, 4, duties.straight_left, duties.straight_right, 10);
    CHECK(left.turn_rad_s / degree > 32);
    CHECK(left.turn_rad_s / degree < 47);
    CHECK(right.turn_rad_s / degree < -32);
    CHECK(right.turn_rad_s / degree > -47);
    CHECK(ahead.speed_m_s > 0.0085);
    CHECK(ahead.speed_m_s < 0.015);
    CHECK(std::abs(ahead.turn_rad_s) / degree < 4);
  }
}

TEST_CASE("identity calibration: dead robots fail by themselves, one between them walks away first") {
  // Three dead robots say why they fail and keep nobody waiting; one wedged in between two of them goes where there is
  // room, and is calibrated as the free one is.
  ArenaSwarm swarm({.program = calibrate_motors_c,
                    .robots = 5,
                    .side_m = 1.2,
                    .ids = {0, 1, 2, 3, 4},
                    .ode = "start_poses = [-0.4, 0.4, 0, 0.4, 0.4, 0, 0.034, 0, 0, 0, 0, 0, -0.034, 0, 0]"});
  swarm.run();
  swarm.arena().set_power(0, false);
  for (int robot : {2, 4}) swarm.arena().set_power(robot, false);
  MotorCalibrator calibrator(
      {.width_m = 1.2, .height_m = 1.2, .body_radius_m = hal::kilobot::body_radius_m, .max_per_robot_s = 300},
      numbers(5));
  run(swarm, calibrator, 1800);
  for (const auto& entry : calibrator.robots()) {
    const auto& [id, robot] = entry;
    INFO("robot ", entry.first, ": ", entry.second.why);
    const bool alive = id == 1 || id == 3;
    CHECK((robot.stage == MotorCalibrator::Stage::done) == alive);
    CHECK(robot.stored == alive);
    CHECK(robot.why.empty() == alive);
  }
  CHECK(calibrator.robots().at(0).why.find("does not move") != std::string::npos);
}

TEST_CASE("identity calibration: what a path says") {
  // Exact paths: a circle of 15 mm in 9 s, a straight of 10 mm/s, an arc that turns 3 degrees a second to the right,
  // and noise of a millimetre on a robot that stands still.
  tracker::MotionLog circle, straight, arc, still, nothing;
  hal::RandomStream chance(1, "test/log");
  for (int n = 0; n <= 120; ++n) {
    const hal::LabTime at{n * 100'000};
    const double s = n * 0.1, turned = 2 * std::numbers::pi * s / 9;
    circle.add(at, 0.3 + 0.015 * std::sin(turned), 0.015 - 0.015 * std::cos(turned));
    straight.add(at, 0.01 * s, -0.2);
    const double radius_m = 0.01 / (3 * degree);
    arc.add(at, radius_m * std::sin(3 * degree * s), radius_m * (std::cos(3 * degree * s) - 1));
    still.add(at, 0.001 * chance.normal(), 0.001 * chance.normal());
  }
  CHECK(circle.path_speed_m_s(4) == doctest::Approx(2 * std::numbers::pi * 0.015 / 9).epsilon(0.01));
  CHECK(circle.circle().radius_m == doctest::Approx(0.015).epsilon(1e-6));
  CHECK(circle.circle().off_m < 1e-6);
  REQUIRE(circle.came_back_s(0.015, 0.002));
  CHECK(*circle.came_back_s(0.015, 0.002) == doctest::Approx(8.8).epsilon(0.02));
  CHECK(straight.net_speed_m_s() == doctest::Approx(0.01));
  CHECK(straight.mean_off_chord_m() < 1e-12);
  CHECK(straight.course_rate_rad_s() == doctest::Approx(0));
  CHECK_FALSE(straight.came_back_s(0.015, 0.002));
  CHECK(arc.course_rate_rad_s() / degree == doctest::Approx(-3).epsilon(0.02));
  CHECK(still.path_speed_m_s(4) < 0.25 * 0.03);
  CHECK(nothing.path_speed_m_s(1) == 0);
  CHECK(nothing.net_speed_m_s() == 0);
  CHECK(nothing.circle().radius_m == 0);
  CHECK(nothing.course_rate_rad_s() == 0);
}
