// The firmware's states, without a program: a command in, what it does out.
#include "sim_ode/host/turns/firmware.hpp"

#include <doctest/doctest.h>

#include <initializer_list>
#include <utility>
#include <vector>

namespace arkmesh::sim_ode {
namespace {

using State = Firmware::State;
using Outputs = Effects::Outputs;

using Steps = std::vector<std::pair<Duties, std::int64_t>>;

struct Robot {
  Firmware firmware;
  RobotValues values{.uid = 0b101, .duties = {71, 72, 61, 62}};
  BootLoader loader;

  Effects hear(std::uint8_t type, std::initializer_list<int> data = {}) {
    Message command;
    command.type = type;
    std::size_t k = 0;
    for (int byte : data) command.data[k++] = static_cast<std::uint8_t>(byte);
    return firmware.hear(command, values, loader);
  }
  Steps steers(std::int64_t from_us = 0) {
    Steps out;
    firmware.steer(from_us, values, [&out](Duties duties, std::int64_t us) { out.push_back({duties, us}); });
    return out;
  }
  static Robot in(State state) {
    Robot out;
    out.firmware = Firmware(state);
    return out;
  }
};

}  // namespace

TEST_CASE("firmware: commands that lead to a state") {
  // From every state in which a program or nothing runs, each command leads to its state; all but RUN cut the motors.
  const std::pair<std::uint8_t, State> leads[] = {{type_run, State::running},     {type_wakeup, State::idle},
                                                  {type_charge, State::charging}, {type_voltage, State::battery},
                                                  {type_sleep, State::sleeping},  {type_boot, State::loader}};
  for (State from : {State::idle, State::running, State::battery, State::charging, State::moving})
    for (const auto& lead : leads) {
      const auto& [type, to] = lead;
      CAPTURE(static_cast<int>(from));
      CAPTURE(static_cast<int>(lead.first));
      Robot robot = Robot::in(from);
      const Effects effects = robot.hear(type);
      CHECK(robot.firmware.state() == to);
      CHECK_FALSE(effects.save);
      if (type != type_run)
        CHECK(effects.outputs == Outputs::cut);
      else
        CHECK(effects.outputs == (from == State::running ? Outputs::keep : Outputs::connect));
    }
}

TEST_CASE("firmware: run, pause, run") {
  // setup is due once; a pause keeps it done.
  Robot robot;
  CHECK_FALSE(robot.firmware.runs());
  robot.hear(type_run);
  CHECK(robot.firmware.runs());
  CHECK_FALSE(robot.firmware.has_setup());
  robot.firmware.setup_is_done();
  robot.hear(type_wakeup);
  CHECK_FALSE(robot.firmware.runs());
  robot.hear(type_run);
  CHECK(robot.firmware.runs());
  CHECK(robot.firmware.has_setup());
}

TEST_CASE("firmware: reset") {
  // After RESET nothing runs or sends any more until power-up.
  Robot robot;
  robot.hear(type_run);
  robot.firmware.setup_is_done();
  robot.firmware.count(20);
  CHECK(robot.firmware.due(3906));
  CHECK(robot.hear(type_reset).outputs == Outputs::cut);
  CHECK(robot.firmware.resets());
  CHECK_FALSE(robot.firmware.runs());
  CHECK_FALSE(robot.firmware.due(3906));
}

TEST_CASE("firmware: unknown commands") {
  // Types that mean nothing to it cut the motors and change nothing else.
  for (std::uint8_t type : {std::uint8_t{139}, std::uint8_t{200}, std::uint8_t{255}}) {
    Robot robot = Robot::in(State::running);
    CHECK(robot.hear(type).outputs == Outputs::cut);
    CHECK(robot.firmware.state() == State::running);
  }
}

TEST_CASE("firmware: reading an id") {
  // A robot turns left for a bit of its id that is 1, and stands for one that is 0 or beyond.
  Robot robot;
  const Effects effects = robot.hear(type_read_uid, {0});
  CHECK(robot.firmware.state() == State::moving);
  CHECK(effects.outputs == Outputs::connect);
  CHECK(effects.colour == 0);
  CHECK(robot.steers() == Steps{{{255, 0}, 0}, {{71, 0}, 15'000}});
  CHECK(robot.hear(type_read_uid, {1}).outputs == Outputs::keep);
  CHECK(robot.steers() == Steps{{{0, 0}, 0}});
  CHECK_FALSE(robot.hear(type_read_uid, {2}).colour);
  CHECK(robot.steers() == Steps{{{255, 0}, 0}, {{71, 0}, 15'000}});
  robot.hear(type_read_uid, {16});
  CHECK(robot.steers() == Steps{{{0, 0}, 0}});
}

TEST_CASE("firmware: calibration") {
  // Values count at once and are kept when they are saved, which a robot does only while it moves; a value that it was
  // told last is nothing new.
  Robot robot;
  CHECK(robot.hear(type_calibrate, {0}).save == false);
  CHECK(robot.firmware.state() == State::idle);
  CHECK(robot.hear(type_calibrate, {1, 0x34, 0x12}).outputs == Outputs::connect);
  CHECK(robot.steers() == Steps{{{0, 0}, 0}});
  robot.hear(type_calibrate, {2, 0, 0, 80});
  CHECK(robot.steers() == Steps{{{255, 0}, 0}, {{80, 0}, 15'000}});
  robot.hear(type_calibrate, {2, 0, 0, 80});
  CHECK(robot.steers().empty());
  robot.hear(type_calibrate, {3, 0, 0, 0, 81});
  CHECK(robot.steers() == Steps{{{0, 255}, 0}, {{0, 81}, 15'000}});
  robot.hear(type_calibrate, {4, 0, 0, 0, 0, 63, 64});
  CHECK(robot.steers() == Steps{{{255, 255}, 0}, {{63, 64}, 15'000}});
  CHECK(robot.values.uid == 0x1234);
  CHECK(robot.values.duties == Calibration{80, 81, 63, 64});
  CHECK(robot.hear(type_calibrate, {9}).outputs == Outputs::keep);
  CHECK(robot.steers().empty());
  const Effects saved = robot.hear(type_calibrate, {0});
  CHECK(saved.save);
  CHECK(saved.outputs == Outputs::cut);
  CHECK(robot.firmware.state() == State::idle);
  CHECK(robot.hear(type_calibrate, {4, 0, 0, 0, 0, 63, 64}).outputs == Outputs::connect);
  CHECK(robot.steers().empty());
}

TEST_CASE("firmware: motors spin up") {
  // Full power lasts 15 ms, past the end of a tick too, and ends with the state.
  Robot robot;
  robot.hear(type_calibrate, {2, 0, 0, 80});
  CHECK(robot.steers(20'000) == Steps{{{255, 0}, 20'000}});
  CHECK(robot.steers() == Steps{{{80, 0}, 20'000 + 15'000 - tick_us}});
  CHECK(robot.steers().empty());
  robot.hear(type_calibrate, {2, 0, 0, 81});
  CHECK(robot.steers(20'000) == Steps{{{255, 0}, 20'000}});
  robot.hear(type_wakeup);
  robot.hear(type_calibrate, {2, 0, 0, 81});
  CHECK(robot.steers().empty());
}

TEST_CASE("firmware: sleep") {
  // A command that was said while it slept is heard 8 s after it fell asleep or a multiple, once.
  Robot robot;
  robot.hear(type_sleep);
  CHECK(robot.firmware.sleeps());
  robot.firmware.fall_asleep(100);
  robot.firmware.fall_asleep(120);
  CHECK(robot.firmware.wake(344) == 0);  // nobody said anything
  robot.firmware.say_asleep(type_run);
  robot.firmware.say_asleep(type_wakeup);
  CHECK(robot.firmware.wake(345) == 0);
  CHECK(robot.firmware.wake(587) == 0);
  CHECK(robot.firmware.wake(588) == type_wakeup);
  CHECK(robot.firmware.wake(588) == 0);
}

TEST_CASE("firmware: boot loader") {
  // In the boot loader it hears the loader's messages, shows its colour, and leaves it by a reset.
  Robot robot;
  robot.hear(type_boot);
  const Effects effects = robot.hear(type_boot_page, {0});
  CHECK(effects.outputs == Outputs::keep);
  CHECK(effects.colour == robot.loader.colour());
  CHECK(effects.colour != 0);
  CHECK_FALSE(robot.firmware.resets());
  CHECK(robot.hear(type_run).outputs == Outputs::cut);
  CHECK(robot.firmware.resets());
}

TEST_CASE("firmware: a message sooner or later") {
  // A message that is due a tick later or sooner than its period says comes after 17 or 15 ticks.
  for (const int later : {-1, 0, 1}) {
    Robot robot;
    robot.hear(type_run);
    robot.firmware.setup_is_done();
    robot.firmware.has_sent(later);
    int ticks = 0;
    do {
      robot.firmware.count(1);
      ++ticks;
    } while (!robot.firmware.due(3906));
    CHECK(ticks == 16 + later);
  }
}

TEST_CASE("firmware: send timer") {
  // Due every 16 ticks while its loop has turns; counts on, and wraps, while it has none.
  Robot robot;
  robot.firmware.count(16);
  CHECK_FALSE(robot.firmware.due(3906));
  robot.hear(type_run);
  CHECK_FALSE(robot.firmware.due(3906));
  robot.firmware.setup_is_done();
  CHECK(robot.firmware.due(3906));
  robot.firmware.has_sent();
  robot.firmware.count(15);
  CHECK_FALSE(robot.firmware.due(3906));
  robot.firmware.count(1);
  CHECK(robot.firmware.due(3906));
  robot.firmware.count(257 - 16);  // 65535
  CHECK(robot.firmware.due(3906));
  robot.firmware.count(1);
  CHECK_FALSE(robot.firmware.due(3906));
}

TEST_CASE("firmware: what it shows") {
  // Its LED changes once with the state: the battery's colour, dark, or what the program or a command says.
  for (const auto& [voltage, colour] : {std::pair{683, 0x0C}, {682, 0x30}, {648, 0x0F}, {614, 0x03}}) {
    Robot robot;
    robot.hear(type_voltage);
    CHECK(robot.firmware.show(static_cast<std::int16_t>(voltage)) == colour);
    CHECK_FALSE(robot.firmware.show(static_cast<std::int16_t>(voltage)));
    robot.hear(type_charge);
    CHECK(robot.firmware.show(700) == 0);
    robot.hear(type_run);
    CHECK_FALSE(robot.firmware.show(700));
    robot.hear(type_wakeup);
    CHECK(robot.firmware.show(700) == 0);
    robot.hear(type_read_uid);
    CHECK_FALSE(robot.firmware.show(700));
  }
}

}  // namespace arkmesh::sim_ode
