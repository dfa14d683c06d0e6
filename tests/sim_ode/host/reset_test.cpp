// RESET of a robot that runs: its program ends there and then.
#include "sim_ode/host/robot_host.hpp"
#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {
namespace {

using Kind = hal::FleetCommand::Kind;

Inbox command(std::uint8_t type) {
  Inbox out;
  out.overhead.push_back({.message = {.type = type}, .missed = {}});
  return out;
}

}  // namespace

TEST_CASE("reset leaves nothing lit") {
  // A robot that is reset is dark and stays dark, also when its program has just changed its LED.
  auto arena = TestArena{.program = "reset_lit.c", .robots = 3}.make();
  double at_s = 0;
  for (int k = 0; k < 20; ++k) {
    arena->robots().command({.kind = Kind::run});
    for (const hal::Observation& robot : frame_at(*arena, seconds(at_s += 0.5)).robots)
      CHECK(robot.led != hal::Led::off);
    arena->robots().command({.kind = Kind::reset});
    for (const hal::Observation& robot : frame_at(*arena, seconds(at_s += 0.3)).robots)
      CHECK(robot.led == hal::Led::off);
  }
}

TEST_CASE("reset robots are not asked for messages") {
  // kilo_message_tx is not called between RESET and setup (the program asserts it); sending goes on after RUN.
  auto arena = TestArena{.program = "reset_talks.c", .robots = 3}.make();
  double at_s = 0;
  std::uint64_t sent = 0;
  for (int k = 0; k < 20; ++k) {
    arena->robots().command({.kind = Kind::run});
    arena->advance_to(seconds(at_s += 0.4));
    arena->robots().command({.kind = Kind::reset});
    arena->advance_to(seconds(at_s += 0.2));
    CHECK(arena->counters()["infrared.sent"] > sent);
    sent = arena->counters()["infrared.sent"];
    arena->advance_to(seconds(at_s += 0.2));
    CHECK(arena->counters()["infrared.sent"] == sent);
  }
}

TEST_CASE("reset gives back stacks") {
  // Whatever moment RESET comes at, no stack stays with a robot that is reset.
  const DriveSettings settings;
  Motors motors(settings, 5, "shark", 1);
  LedLights leds(5);
  RobotHost host(RobotProgram::load(controller("waits_at_times.c")), 5, motors, leds, {}, "shark", 1);
  std::int64_t tick = 0;
  std::uint64_t most = 0;
  for (int ticks = 1; ticks < 20; ++ticks) {
    host.tick(++tick, command(type_run));
    for (int k = 0; k < ticks; ++k) {
      host.tick(++tick, {});
      most = std::max(most, host.stacks_in_use());
    }
    host.tick(++tick, command(type_reset));
    CHECK(host.stacks_in_use() == 0);
  }
  CHECK(most == 5);
}

}  // namespace arkmesh::sim_ode
