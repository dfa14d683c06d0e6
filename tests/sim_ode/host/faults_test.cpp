// Programs that do not compile, crash, hang or give up end an arena with one sentence, and nothing else.
#include <dlfcn.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/sim_ode/arena_builder.hpp"
#include "tests/support/processes/sanitized.hpp"

namespace arkmesh::sim_ode {
namespace {

std::string config_error(const std::string& program) {
  try {
    TestArena{.program = program}.make();
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
  return "";
}

// The sentence with which a run ends; empty when it lasts 10 s.
std::string run_error(const std::string& program, int robots = 4, const std::string& ode = "") {
  auto arena = TestArena{.program = program, .robots = robots, .ode = ode}.make_running();
  std::string first;
  try {
    for (int k = 0; k <= 100; ++k) {
      arena->advance_to(seconds(0.1 * k));
      if (k == 10) arena->robots().command(broadcast(1, {0}));
    }
  } catch (const std::runtime_error& error) {
    first = error.what();
  }
  if (first.empty()) return first;
  // the arena stays lost, with the same words
  try {
    arena->advance_to(seconds(20));
    FAIL("a lost arena went on");
  } catch (const std::runtime_error& error) {
    CHECK(error.what() == first);
  }
  return first;
}

bool says(const std::string& sentence, std::initializer_list<const char*> words) {
  CAPTURE(sentence);
  for (const char* word : words)
    if (sentence.find(word) == std::string::npos) {
      MESSAGE("missing: " << word << " in: " << sentence);
      return false;
    }
  return true;
}

int entries_of(const std::filesystem::path& directory, const std::string& beginning) {
  int n = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    n += entry.path().filename().string().starts_with(beginning);
  return n;
}

int open_files() {
  return entries_of("/proc/self/fd", "");
}

int mappings() {
  std::ifstream in("/proc/self/maps");
  int n = 0;
  // fresh, or out of the cache
  for (std::string line; std::getline(in, line);)
    n += line.find("program.so") != std::string::npos || line.find("/arkmesh/controllers/") != std::string::npos;
  return n;
}

}  // namespace

TEST_CASE("does not compile") {
  // A ConfigError names the key, the program's own file and line, and what the compiler says.
  CHECK(says(config_error("does_not_compile.c"), {"arena.ode.controller", "does_not_compile.c:3", "nonsense"}));
  CHECK(says(config_error("not_there.c"), {"not_there.c", "cannot be read"}));
  CHECK(says(config_error("no_start.c"), {"never calls kilo_start"}));
}

TEST_CASE("crashes") {
  // A crash names robot, kind, function, line and time, wherever it happens.
  CHECK(says(run_error("crash_null.c"), {"robot 2", "bad pointer", "loop", "crash_null.c:9", " at 1.", " s ("}));
  CHECK(says(run_error("crash_zero.c"), {"robot 0", "division by zero", "rx", "crash_zero.c:5"}));
  CHECK(says(run_error("crash_stack.c"), {"robot 0", "stack overflow"}));
  CHECK(says(run_error("crash_call.c"), {"robot 0", "bad pointer", "in loop", "crash_call.c:9"}));
  CHECK(says(run_error("crash_beyond.c"), {"robot 0", "bad pointer", "crash_beyond.c"}));
}

TEST_CASE("a robot that fails is left behind") {
  // With on_fault = "leave" the others go on, in the same way each time, whatever they were doing: in loop, in a
  // callback, on a stack that overflows, in a program that never returns.
  for (const char* program : {"crash_null.c", "crash_zero.c", "crash_stack.c", "endless.c", "jumps.c"}) {
    CAPTURE(program);
    const TestArena scene{.program = program, .robots = 4, .ode = "on_fault = \"leave\""};
    std::uint64_t failed[2] = {}, places[2] = {};
    for (int again = 0; again < 2; ++again) {
      auto arena = scene.make_running();
      arena->advance_to(seconds(1));
      arena->robots().command(broadcast(1, {0}));
      const hal::PoseFrame frame = frame_at(*arena, seconds(10));
      CHECK(frame.robots.size() == 4);
      failed[again] = arena->counters()["robots.failed"];
      for (const hal::Observation& robot : frame.robots)
        places[again] = places[again] * 31 + static_cast<std::uint64_t>(std::llround(robot.pose.x_m * 1e6));
    }
    CHECK(failed[0] > 0);
    CHECK(failed[1] == failed[0]);
    CHECK(places[1] == places[0]);
  }
  // One of four is lost, and the others move on.
  auto arena = TestArena{.program = "crash_ahead.c", .robots = 4, .ode = "on_fault = \"leave\""}.make_running();
  const hal::PoseFrame then = frame_at(*arena, seconds(3)), later = frame_at(*arena, seconds(9));
  CHECK(arena->counters()["robots.failed"] == 1);
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(i);
    const hal::Pose &before = then.robots[i].pose, &after = later.robots[i].pose;
    CHECK((std::hypot(after.x_m - before.x_m, after.y_m - before.y_m) > 0.001) == (i != 2));
  }
}

TEST_CASE("a damaged stack is its robot's") {
  // However far above an array on its stack a robot writes, only that robot fails, the same ones in each run; those
  // that write nowhere else move on. A write far above is named with its line.
  // With a sanitizer a function of C++ lies between program and host, without traps around it.
  if (tests::sanitized) return;
  const TestArena scene{.program = "damages_stack.c", .robots = 600, .side_m = 3, .ode = "on_fault = \"leave\""};
  std::uint64_t failed[2] = {};
  for (std::uint64_t& robots : failed) {
    auto arena = scene.make_running();
    const hal::PoseFrame then = frame_at(*arena, seconds(3)), later = frame_at(*arena, seconds(6));
    robots = arena->counters()["robots.failed"];
    for (std::size_t i = 0; i < 4; ++i) {
      const hal::Pose &before = then.robots[i].pose, &after = later.robots[i].pose;
      CHECK(std::hypot(after.x_m - before.x_m, after.y_m - before.y_m) > 0.001);
    }
  }
  CHECK(failed[0] == 300);
  CHECK(failed[1] == failed[0]);
  CHECK(says(run_error("damages_stack.c", 1, "ids = [599]"),
             {"robot 0", "beyond its stack", "in damage", "damages_stack.c:11"}));
}

TEST_CASE("aborts") {
  // What the C library ends a program for is told like any other crash: a copy that does not fit.
  CHECK(says(run_error("crash_copy.c"), {"the program of robot 0 crashed: ", " at 0.", " s (", "crash_copy.c"}));
}

TEST_CASE("hangs and giving up") {
  // An endless loop, also one of delay(0), is ended with its place; exit() ends the run, not the process.
  CHECK(says(run_error("endless.c"), {"robot 0", "never returns", "in loop", "endless.c:7", "at 8."}));
  CHECK(says(run_error("endless_delay.c"), {"robot 0", "never returns"}));
  CHECK(says(run_error("gives_up.c"), {"robot 0", "called exit()", "gives_up.c:"}));
  // so do what else would end the process or take signals from it
  CHECK(says(run_error("leaves.c"), {"robot 0", "called _Exit()", "leaves.c:6"}));
  CHECK(says(run_error("raises.c"), {"robot 0", "called raise()", "raises.c:6"}));
  CHECK(says(run_error("handles.c"), {"robot 0", "called signal()", "handles.c:6"}));
  CHECK(says(run_error("jumps.c"), {"robot 0", "called longjmp() in a callback", "in rx", "jumps.c:8"}));
}

TEST_CASE("waiting for a flag") {
  // A loop that only waits for a variable which a callback sets goes on as on a robot, the same way in each run.
  const TestArena scene{.program = "wait_for_flag.c", .robots = 2, .ode = "start_poses = [0, 0, 0, 0.05, 0, 0]"};
  auto arena = scene.make_running(), again = scene.make_running();
  const hal::PoseFrame frame = frame_at(*arena, seconds(6)), same = frame_at(*again, seconds(6));
  for (std::size_t i = 0; i < 2; ++i) CHECK(frame.robots[i].led == hal::Led::green);
  CHECK(same.robots[0].led == frame.robots[0].led);
  CHECK(arena->counters()["infrared.received"] == again->counters()["infrared.received"]);
}

TEST_CASE("other arenas go on") {
  // After a crash in one arena another one in the same process still runs, and new ones start.
  auto good = TestArena{.program = "all_ahead.c", .robots = 3}.make_running();
  const hal::Pose start = frame_at(*good, hal::LabTime{0}).robots[1].pose;
  CHECK_FALSE(run_error("crash_stack.c").empty());
  CHECK(frame_at(*good, seconds(5)).robots[1].pose.x_m != start.x_m);
  CHECK(run_error("all_ahead.c").empty());
}

TEST_CASE("nothing is left behind") {
  // Arenas made and destroyed, failed ones too, leave no directories, open files or loaded programs.
  // a temporary folder of our own, where nobody else compiles
  std::string own = (std::filesystem::temp_directory_path() / "arkmesh-test-XXXXXX").string();
  REQUIRE(mkdtemp(own.data()));
  const char* const before = std::getenv("TMPDIR");
  const std::string usual = before ? before : "";
  setenv("TMPDIR", own.c_str(), 1);
  const std::filesystem::path temporary = own;
  { auto warm_up = TestArena{.program = "wander.c"}.make(); }
  const int folders = entries_of(temporary, "arkmesh-controller-"), files = open_files(), programs = mappings();
  for (int k = 0; k < 5; ++k) {
    auto a = TestArena{.program = "wander.c"}.make_running(),
         b = TestArena{.program = "wander.c", .seed = 2}.make_running();
    auto c = TestArena{.program = "rounds.c", .robots = 5}.make_running();
    c->advance_to(seconds(1));
    CHECK(mappings() > programs);
    config_error("does_not_compile.c");
  }
  run_error("crash_null.c");
  CHECK(entries_of(temporary, "arkmesh-controller-") == folders);
  CHECK(open_files() == files);
  CHECK(mappings() == programs);
  if (before)
    setenv("TMPDIR", usual.c_str(), 1);
  else
    unsetenv("TMPDIR");
  std::filesystem::remove_all(own);
}

}  // namespace arkmesh::sim_ode
