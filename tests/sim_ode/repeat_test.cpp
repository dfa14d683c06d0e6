// The same seed gives the same run, whatever else happens in the process and however the time is sliced.
#include <cstring>

#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {
namespace {

// Bits of everything a camera sees.
std::uint64_t hash(const hal::PoseFrame& frame, std::uint64_t h) {
  const auto add = [&h](std::uint64_t bits) { h = (h ^ bits) * 0x100000001b3ULL; };
  for (const hal::Observation& robot : frame.robots) {
    for (double value : {robot.pose.x_m, robot.pose.y_m, robot.pose.heading_rad}) {
      std::uint64_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      add(bits);
    }
    add(static_cast<std::uint64_t>(robot.led));
  }
  return h;
}

constexpr int frames = 300;

void talk(hal::Arena& arena, int k) {
  std::vector<hal::ToRobot> all;
  for (hal::RobotId id : arena.info().robots)
    all.push_back({id, 0, static_cast<std::uint8_t>(k % 16), static_cast<std::uint16_t>(k)});
  arena.robots().offer(all);
}

std::uint64_t run_alone(const TestArena& scene) {
  auto arena = scene.make_running();
  std::uint64_t h = 1;
  for (int k = 0; k <= frames; ++k) {
    h = hash(frame_at(*arena, seconds(0.1 * k)), h);
    if (k % 10 == 0) talk(*arena, k);
  }
  return h;
}

}  // namespace

TEST_CASE("two arenas in turn") {
  // Two arenas that share a program and the process's ODE, stepped in turn, do what each does alone; another seed
  // differs.
  const TestArena a{.robots = 60, .side_m = 0.4, .seed = 1}, b{.robots = 20, .side_m = 0.3, .seed = 2, .lab = "roark"};
  const std::uint64_t alone_a = run_alone(a), alone_b = run_alone(b);
  CHECK(run_alone(a) == alone_a);
  TestArena other = a;
  other.seed = 3;
  CHECK(run_alone(other) != alone_a);

  auto one = a.make_running(), two = b.make_running();
  std::uint64_t h1 = 1, h2 = 1;
  for (int k = 0; k <= frames; ++k) {
    h1 = hash(frame_at(*one, seconds(0.1 * k)), h1);
    h2 = hash(frame_at(*two, seconds(0.1 * k)), h2);
    if (k % 10 == 0) talk(*one, k), talk(*two, k);
  }
  CHECK(h1 == alone_a);
  CHECK(h2 == alone_b);
}

TEST_CASE("slices of time") {
  // advance_to in uneven slices changes nothing; every frame that a slice ends on is the same.
  const TestArena scene{.robots = 40, .side_m = 0.4};
  const std::uint64_t whole = run_alone(scene);
  auto arena = scene.make_running();
  std::uint64_t h = 1;
  hal::LabTime at{0};
  for (int k = 0; k <= frames; ++k) {
    const hal::LabTime end = seconds(0.1 * k);
    // 7.777 ms at a time, and each moment twice
    for (; at < end; at += hal::LabTime{7777}) arena->advance_to(at), arena->advance_to(at);
    h = hash(frame_at(*arena, end), h);
    at = end;
    if (k % 10 == 0) talk(*arena, k);
  }
  CHECK(h == whole);
}

TEST_CASE("frames between ticks") {
  // Frames show robots on their way between two ticks: a straight drive is straight and even at any frame period.
  auto arena = TestArena{.program = "ahead.c",
                         .ode = std::string(exact_drive) + "\nstart = \"centre80\"",
                         .arena = "frame_period_s = 0.01"}
                   .make_running();
  arena->advance_to(seconds(1));
  arena->poses().latest();
  hal::Pose last{};
  for (int k = 101; k < 200; ++k) {
    const hal::Pose now = frame_at(*arena, seconds(0.01 * k)).robots[0].pose;
    if (k > 101) CHECK(std::hypot(now.x_m - last.x_m, now.y_m - last.y_m) == doctest::Approx(0.0001).epsilon(1e-6));
    last = now;
  }
}

TEST_CASE("frame 0") {
  // Frame 0 is there after advance_to(0), robots stand until RUN has been heard, skipped frames are counted.
  auto arena = TestArena{.program = "all_ahead.c", .robots = 5}.make();
  const hal::PoseFrame first = frame_at(*arena, hal::LabTime{0});
  CHECK(first.number == 0);
  CHECK_FALSE(arena->poses().latest());
  arena->advance_to(seconds(1));
  const auto later = arena->poses().latest();
  REQUIRE(later);
  CHECK(later->number == 10);
  CHECK(arena->counters()["poses.skipped"] == 9);
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(later->robots[i].pose.x_m == first.robots[i].pose.x_m);
    CHECK(later->robots[i].led == hal::Led::off);
  }
  arena->robots().command({.kind = hal::FleetCommand::Kind::run});
  CHECK(frame_at(*arena, seconds(2)).robots[0].pose.x_m != first.robots[0].pose.x_m);
}

TEST_CASE("blank LEDs") {
  // With arena.blank_leds cameras see no colour, and nothing else changes.
  TestArena scene{.program = "states.c", .robots = 2, .arena = "blank_leds = true"};
  auto blank = scene.make_running();
  scene.arena.clear();
  auto seen = scene.make_running();
  const hal::PoseFrame a = frame_at(*blank, seconds(5)), b = frame_at(*seen, seconds(5));
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(a.robots[i].led == hal::Led::off);
    CHECK(b.robots[i].led == hal::Led::blue);
    CHECK(a.robots[i].pose.x_m == b.robots[i].pose.x_m);
  }
}

}  // namespace arkmesh::sim_ode
