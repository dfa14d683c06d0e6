// The robots' library, and programs in the styles that people write.
#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {

static void shows_green(const std::string& program, double after_s, int robots = 1, int first = 0) {
  CAPTURE(program);
  TestArena scene{.program = program, .robots = robots, .side_m = 0.12};
  auto arena = scene.make_running();
  const hal::PoseFrame frame = frame_at(*arena, seconds(after_s));
  for (const hal::Observation& robot : frame.robots)
    if (static_cast<int>(robot.robot) >= first) CHECK(robot.led == hal::Led::green);
}

TEST_CASE("library values") {
  // Checksums, generators, distances and limits are those of a robot: the program asserts each and shows green.
  shows_green("api.c", 1);
  shows_green("rand_soft_seeded.c", 1);
}

TEST_CASE("names belong to programs") {
  // A program may use the names of other headers and of the C library, old-style callbacks and tentative definitions.
  shows_green("names.c", 1);
}

TEST_CASE("buffered messages") {
  // message_buffered.h and debug.h work: four numbered messages arrive in order.
  shows_green("buffered.c", 5, 2, 1);
}

TEST_CASE("one-slot flags see every message") {
  // loop runs between two messages of the same tick, so a program that keeps only the newest loses none.
  TestArena scene{.program = "flag.c", .robots = 4, .side_m = 0.12};
  auto arena = scene.make_running();
  const hal::PoseFrame frame = frame_at(*arena, seconds(34.5));
  for (std::size_t i = 1; i < 4; ++i) CHECK(frame.robots[i].led == hal::Led::green);
}

TEST_CASE("waiting by reading the clock") {
  // `while (kilo_ticks < t);` takes lab time instead of hanging, and kilo_ticks may be assigned: 30 ticks on, 30 off.
  TestArena scene{.program = "busy_wait.c"};
  auto arena = scene.make_running();
  int green = 0;
  for (int k = 1; k <= 400; ++k) green += frame_at(*arena, seconds(0.1 * k)).robots[0].led == hal::Led::green;
  CHECK(green >= 190);
  CHECK(green <= 210);
}

TEST_CASE("delay takes its time") {
  // Two delays of 500 ms are a round of exactly 1 s, two of 100 ms one of 0.2 s, whatever the tick: 600 and 3000 rounds
  // in 600 s.
  for (const auto& row : {std::pair{"rounds.c", 600}, std::pair{"short_rounds.c", 3000}}) {
    const auto& [program, rounds] = row;
    CAPTURE(row.first);
    auto arena = TestArena{.program = program, .robots = 3}.make_running();
    arena->advance_to(seconds(600));
    arena->robots().command(broadcast(2, {rounds & 255, rounds >> 8}));
    arena->advance_to(seconds(600.1));
    const hal::PoseFrame frame = frame_at(*arena, seconds(600.2));
    for (const hal::Observation& robot : frame.robots) CHECK(robot.led == hal::Led::blue);
  }
}

}  // namespace arkmesh::sim_ode
