// What robots' sensors read.
#include <cmath>
#include <numbers>

#include "sim_ode/light_field.hpp"
#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {

TEST_CASE("light of a lamp") {
  // Readings fall with distance and with the angle off the lamp by the formula, at the sensor's place, and noise stays
  // in its bounds.
  Settings settings;
  settings.lamps = {{1, 0, 0}};
  LightField field(settings, 2, "shark", 1);
  const auto facing = [](double degrees) {
    return std::pair(std::cos(degrees * std::numbers::pi / 180), std::sin(degrees * std::numbers::pi / 180));
  };
  // the sensor looks at the lamp when the robot looks 100 degrees right of it
  CHECK(field.strength(0, 0, facing(-100)) == doctest::Approx(1024 * std::exp(-2 * (1 - 0.0145))));
  CHECK(field.strength(0, 0, facing(80)) == doctest::Approx(0).epsilon(1e-6));
  CHECK(field.strength(0.5, 0, facing(-100)) == doctest::Approx(1024 * std::exp(-2 * (0.5 - 0.0145))));
  double least = 1e9, most = 0;
  for (int k = 0; k < 2000; ++k) {
    const double off = field.reading(0, 0.5, 0, facing(-100)) - field.strength(0.5, 0, facing(-100));
    least = std::min(least, off);
    most = std::max(most, off);
  }
  CHECK(least >= -10.5);
  CHECK(least < -9);
  CHECK(most <= 10.5);
  CHECK(most > 9);
}

TEST_CASE("programs read sensors") {
  // Programs see the lamp from where they stand, the room's even light without lamp, and -1 while the controller's
  // message arrives.
  const std::string places = "start_poses = [0.2, 0, -1.745, -0.45, 0, -1.745, 0.2, 0.3, 1.4]\n";
  const TestArena scene{.program = "thermometer.c", .robots = 3, .ode = places + "lamp = [0.3, 0]"};
  const hal::PoseFrame lit = frame_at(*scene.make_running(), seconds(1));
  CHECK(lit.robots[0].led == hal::Led::red);
  CHECK(lit.robots[1].led == hal::Led::blue);
  const hal::PoseFrame even =
      frame_at(*TestArena{.program = "thermometer.c", .robots = 3, .ode = places}.make_running(), seconds(1));
  for (const hal::Observation& robot : even.robots) CHECK(robot.led == hal::Led::green);

  auto busy = scene.make_running();
  int white = 0;
  for (int k = 1; k <= 100; ++k) {
    std::vector<hal::ToRobot> all;
    for (hal::RobotId id : busy->info().robots) all.push_back({id, 0, static_cast<std::uint8_t>(k % 16), 1});
    busy->robots().offer(all);
    white += frame_at(*busy, seconds(0.1 * k)).robots[0].led == hal::Led::white;
  }
  CHECK(white > 20);
  CHECK(white < 70);
}

}  // namespace arkmesh::sim_ode
