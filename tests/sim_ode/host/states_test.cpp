// What fleet commands do to robots.
#include <cmath>

#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {
namespace {

using Kind = hal::FleetCommand::Kind;

struct Watched {
  std::unique_ptr<hal::Arena> arena;
  double at_s = 0;

  hal::Observation after(double s) { return frame_at(*arena, seconds(at_s += s)).robots[0]; }
  // Whether it moves within 0.5 s.
  bool moves() {
    const hal::Pose a = after(0.1).pose, b = after(0.5).pose;
    return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m) > 0.002;
  }
  void command(Kind kind) { arena->robots().command({.kind = kind}); }
};

Watched watched() {
  return {
      TestArena{.program = "states.c", .side_m = 2, .ode = std::string(exact_drive) + "\nstart = \"centre80\""}.make()};
}

}  // namespace

TEST_CASE("run, pause, run") {
  // RUN starts setup and loop; pause cuts the motors and the LED; the second RUN goes on without setup (the program
  // asserts it).
  Watched w = watched();
  CHECK_FALSE(w.moves());
  CHECK(w.after(0.1).led == hal::Led::off);
  w.command(Kind::run);
  CHECK(w.after(0.2).led == hal::Led::red);
  CHECK(w.moves());
  w.command(Kind::pause);
  CHECK(w.after(0.2).led == hal::Led::off);
  CHECK_FALSE(w.moves());
  CHECK(w.after(3).led == hal::Led::off);
  w.command(Kind::run);
  w.after(0.1);
  CHECK(w.moves());
  CHECK(w.after(2).led == hal::Led::blue);  // loops counted on where they stopped
}

TEST_CASE("reset") {
  // RESET forgets everything: the robot is idle, and RUN runs setup again in fresh memory.
  Watched w = watched();
  w.command(Kind::run);
  CHECK(w.after(3).led == hal::Led::blue);
  w.command(Kind::reset);
  CHECK(w.after(0.2).led == hal::Led::off);
  CHECK_FALSE(w.moves());
  w.command(Kind::run);
  CHECK(w.after(0.2).led == hal::Led::red);
  CHECK(w.after(3).led == hal::Led::blue);
}

TEST_CASE("voltage and charge") {
  // VOLTAGE shows the battery, green when full; CHARGE is dark for a camera; both stop the robot.
  Watched w = watched();
  w.command(Kind::run);
  w.after(1);
  w.command(Kind::voltage);
  CHECK(w.after(0.2).led == hal::Led::green);
  CHECK_FALSE(w.moves());
  w.command(Kind::charge);
  CHECK(w.after(0.2).led == hal::Led::off);
  CHECK_FALSE(w.moves());
  w.command(Kind::run);
  w.after(0.1);
  CHECK(w.moves());
}

TEST_CASE("sleep") {
  // A sleeping robot hears a command at its next wake-up, 8 s after it fell asleep or a multiple.
  Watched w = watched();
  w.command(Kind::run);
  w.after(0.5);
  w.command(Kind::sleep);
  w.after(0.5);
  CHECK_FALSE(w.moves());
  w.command(Kind::run);
  w.after(4);
  CHECK_FALSE(w.moves());
  w.after(4);
  CHECK(w.moves());
}

TEST_CASE("reset inside delay") {
  // A robot that waits in delay() is reset at once; its stack is free for others, again and again.
  auto arena = TestArena{.program = "rounds.c", .robots = 20}.make();
  double at_s = 0;
  for (int k = 0; k < 50; ++k) {
    arena->robots().command({.kind = Kind::run});
    arena->advance_to(seconds(at_s += 0.7));
    arena->robots().command({.kind = Kind::reset});
    arena->advance_to(seconds(at_s += 0.2));
  }
  arena->robots().command({.kind = Kind::run});
  // RUN is heard within 0.1 s; 10 rounds of 1 s follow
  arena->advance_to(seconds(at_s += 10.5));
  arena->robots().command(broadcast(2, {10, 0}));
  arena->advance_to(seconds(at_s += 0.2));
  arena->advance_to(seconds(std::ceil(at_s)));
  auto frame = arena->poses().latest();
  REQUIRE(frame);
  for (const hal::Observation& robot : frame->robots) CHECK(robot.led == hal::Led::blue);
}

}  // namespace arkmesh::sim_ode
