// What robots keep while they are reset or switched off.
#include "sim_ode/host/robot_host.hpp"
#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {
namespace {

struct KeepingRobots {
  Motors motors{DriveSettings{.speed_spread = 0, .duty_spread = 0}, 2, "shark", 1};
  LedLights leds{2};
  RobotHost host{RobotProgram::load(controller("keeps.c")), 2, motors, leds, {}, "shark", 1, {5, 6}};
  std::int64_t tick = 0;

  // Both hear it, or all but one.
  void hear(std::uint8_t type, std::initializer_list<int> data = {}, int deaf = -1) {
    Inbox inbox;
    Message message{.type = type};
    std::size_t k = 0;
    for (int byte : data) message.data[k++] = static_cast<std::uint8_t>(byte);
    inbox.overhead.push_back({.message = message, .missed = {deaf == 0, deaf == 1}});
    host.tick(++tick, inbox);
    leds.end_tick();
    motors.end_tick();
    host.tick(++tick, {});
    leds.end_tick();
    motors.end_tick();
  }
  hal::Led led(std::size_t robot) const {
    std::vector<hal::Led> seen;
    leds.look(0, seen);
    return seen[robot];
  }
};

}  // namespace

TEST_CASE("eeprom: what a program stores survives") {
  // Bytes and variables in the EEPROM outlive a reset and a battery that was out, each robot's own.
  KeepingRobots robots;
  robots.hear(type_run);
  CHECK(robots.led(0) == hal::Led::red);
  robots.hear(type_reset, {}, 1);
  robots.hear(type_run);
  CHECK(robots.led(0) == hal::Led::green);
  CHECK(robots.led(1) == hal::Led::red);
  robots.host.set_power(0, false);
  robots.host.set_power(0, true);
  robots.hear(type_run);
  CHECK(robots.led(0) == hal::Led::blue);
}

TEST_CASE("eeprom: the library's values") {
  // An id that a program stores is the robot's after its reset, and what calibration saves is what a program reads.
  KeepingRobots robots;
  robots.hear(1, {9});
  CHECK(robots.host.id_of(0) == 9);
  robots.hear(2, {9, 70});
  CHECK(robots.led(0) == hal::Led::white);
  robots.hear(type_reset);
  robots.hear(type_calibrate, {2, 0, 0, 81});
  robots.hear(2, {9, 70});
  CHECK(robots.led(0) == hal::Led::white);
  robots.hear(type_calibrate);
  robots.hear(type_reset);
  robots.hear(2, {9, 81});
  CHECK(robots.led(0) == hal::Led::white);
  CHECK(robots.host.id_of(0) == 9);
  CHECK(robots.host.id_of(1) == 9);
}

}  // namespace arkmesh::sim_ode
