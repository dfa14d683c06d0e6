// A program means here what it means on a robot: its types, its memory, its files.
#include <doctest/doctest.h>

#include <cstdlib>
#include <fstream>
#include <optional>

#include "hal/random.hpp"
#include "sim_ode/controller_swarm.hpp"
#include "sim_ode/host/programs/controller_check.hpp"
#include "sim_ode/host/programs/robot_types.hpp"
#include "tests/sim_ode/arena_builder.hpp"
#include "tests/sim_ode/heard_warnings.hpp"
#include "tests/support/processes/temporary_directory.hpp"
#include "tests/support/processes/thorough.hpp"

namespace arkmesh::sim_ode {
namespace {

struct Ran {
  std::vector<hal::Led> leds;
  std::string printed;
  std::uint64_t misuse;
};

Ran run(const std::string& program, int robots, double for_s, SwarmOptions options = {}) {
  options.program = ProgramSources(controller(program));
  options.robots = robots;
  ControllerSwarm swarm(options);
  Ran out;
  swarm.run_until(seconds(for_s), [&](const hal::PoseFrame& frame) {
    out.leds.clear();
    for (const hal::Observation& robot : frame.robots) out.leds.push_back(robot.led);
  });
  for (const ProgramText::Piece& piece : swarm.take_text()) out.printed += piece.text;
  out.misuse = swarm.arena().counters()["robots.heap_misuse"];
  return out;
}

std::vector<hal::Led> all(std::size_t robots, hal::Led led) {
  return std::vector<hal::Led>(robots, led);
}

std::string content(const std::filesystem::path& file) {
  std::ostringstream out;
  out << std::ifstream(file, std::ios::binary).rdbuf();
  return out.str();
}

}  // namespace

TEST_CASE("a program's types are a robot's") {
  const Ran ran = run("types.c", 1, 1);
  CHECK(ran.printed == "0\n");
  CHECK(ran.leds == all(1, hal::Led::green));
}

TEST_CASE("a clock in an int stands still from where it stands on a robot") {
  // 32767 ticks are 1074 s.
  SwarmOptions options;
  options.program = ProgramSources(controller("int_clock.c"));
  options.robots = 1;
  ControllerSwarm swarm(options);
  std::optional<hal::Led> led;
  int before = 0, after = 0;
  swarm.run_until(seconds(1200), [&](const hal::PoseFrame& frame) {
    const double at_s = std::chrono::duration<double>(frame.stamp).count();
    if (led && *led != frame.robots[0].led) ++(at_s < 1074 ? before : after);
    led = frame.robots[0].led;
  });
  CHECK(before > 1900);
  CHECK(after <= 1);
}

TEST_CASE("types are exchanged in the program's lines only, whatever the order of their words") {
  const std::string before =
      "# 1 \"/usr/include/x.h\" 1 3 4\nint system;\n# 3 \"/k/kilolib.h\" 1\nlong ours;\n# 1 \"p.c\" 2\n"
      "unsigned volatile long int a; const unsigned b; signed char c; unsigned short int d; long\nlong e; int_t f;\n"
      "char *g = \"int \\\" long\", h = '\"'; double i = 1.5 + .5e3 + 0x1p3 + 7.f + 2.0L + 5UL + 6l + 7LL + 1ul;\n"
      "x = __builtin_va_arg (v, int) + __builtin_va_arg(v, unsigned long) + (int)1; print(int); long double z;";
  const std::string after =
      "# 1 \"/usr/include/x.h\" 1 3 4\nint system;\n# 3 \"/k/kilolib.h\" 1\nlong ours;\n# 1 \"p.c\" 2\n"
      "unsigned int volatile   a; const unsigned short b; signed char c; unsigned short int d; long\nlong e; int_t f;\n"
      "char *g = \"int \\\" long\", h = '\"'; float i = 1.5f + .5e3f + 0x1p3f + 7.f + 2.0f + 5U + 6 + 7LL + 1u;\n"
      "x = __builtin_va_arg (v, int) + __builtin_va_arg(v, unsigned int ) + (short)1; print(short); float  z;";
  CHECK(with_robot_types(before, "/k") == after);
}

TEST_CASE("a program that does not compile with a robot's types runs with a PC's, and a sentence says so") {
  const Heard heard;
  CHECK(run("pc_types.c", 1, 1).leds == all(1, hal::Led::green));
  CHECK_MESSAGE(heard.says("pc_types.c runs with a PC's types (32-bit int"), heard.text());
  CHECK_MESSAGE(heard.says("pc_types.c:5"), heard.text());
}

TEST_CASE("a robot that writes beyond its block damages itself only, and is named") {
  const Heard heard;
  CHECK(run("overrun.c", 3, 4).leds == std::vector<hal::Led>{hal::Led::green, hal::Led::blue, hal::Led::green});
  CHECK_MESSAGE(heard.says("the program of robot 1 has written beyond the 24 bytes that it allocated in setup "
                           "(overrun.c:9): noticed in loop (overrun.c:13) at 0."),
                heard.text());
}

TEST_CASE("a block that is freed twice is named, and the robot goes on") {
  const Heard heard;
  const Ran ran = run("double_free.c", 4, 3);
  CHECK(ran.misuse > 10);
  CHECK_MESSAGE(
      heard.says("the program of robot 2 frees memory that malloc() did not return, or that it freed before, in "
                 "loop (double_free.c:11) at 1."),
      heard.text());
}

TEST_CASE("a program gets a PC's types when it asks for them") {
  const Heard heard;
  SwarmOptions options;
  options.program = ProgramSources(controller("types.c"));
  options.program.define = {"ARKMESH_PC_TYPES"};
  options.robots = 1;
  ControllerSwarm swarm(options);
  CHECK_MESSAGE(heard.says("types.c runs with a PC's types"), heard.text());
}

TEST_CASE("a folder's copy of kilolib is left out, and what is missing is looked for nearby") {
  const tests::TemporaryDirectory folder;
  const std::filesystem::path own = folder.path() / "my code", other = folder.path() / "other";
  for (const std::filesystem::path& each : {own, other}) std::filesystem::create_directory(each);
  std::ofstream(own / "kilolib.h") << "";
  for (const char* name : {"kilolib.c", "message_crc.c"})
    std::ofstream(own / name) << "void kilo_init() { OCR2A = 0; }\n";
  std::filesystem::copy_file(controller("types.c"), own / "types.c");
  CHECK_NOTHROW(RobotProgram::load(ProgramSources(own)));
  std::ofstream(other / "state.h") << "";
  std::ofstream(own / "types.c") << "#include \"state.h\"\n";
  CHECK_THROWS_WITH_AS(RobotProgram::load(ProgramSources(own)),
                       doctest::Contains(("it lies in " + other.string() + ": name that folder").c_str()),
                       ProgramError);
}

TEST_CASE("programs that lack headers which other simulators bring along run") {
  for (const char* macro : {"OF_ROBOTS", "OF_KILOMBO", "OF_ARGOS"}) {
    CAPTURE(macro);
    const Heard heard;
    SwarmOptions options;
    options.program = ProgramSources(controller("other_headers.c"));
    options.program.define = {macro};
    options.robots = 2;
    ControllerSwarm swarm(options);
    swarm.run_until(seconds(1), [](const hal::PoseFrame&) {});
    CHECK(swarm.arena().counters()["robots.heap_misuse"] == 0);
    CHECK(heard.text() == "");
  }
}

TEST_CASE("a robot's heap has its own end") {
  const Heard heard;
  CHECK(run("leaks.c", 4, 10).leds == all(4, hal::Led::blue));
  CHECK(heard.text() == "");
}

TEST_CASE("robots' files lie in a folder of each robot's own, with what it printed") {
  const tests::TemporaryDirectory folder;
  const auto config = hal::Config::from_text(
      "[arena]\nrobots = 2\n[arena.ode]\ncontroller = \"" + controller("files.c").string() + "\"\n", "test.toml");
  {
    const auto arena =
        make_ode_arena(config.root().section("arena"), "lab", 1, {.text = nullptr, .folder = folder.path() / "robots"});
    arena->robots().command({.kind = hal::FleetCommand::Kind::run});
    hal::advance(*arena, seconds(1));
    while (const auto frame = arena->poses().latest()) CHECK(frame->robots[0].led == hal::Led::green);
  }
  for (const std::string id : {"0", "1"}) {
    const std::filesystem::path own = folder.path() / "robots" / id;
    CHECK(content(own / "logs" / ("log_" + id + ".tsv")) ==
          (id == "0" ? "7" : "8") + std::string("\ttext\nab\0cd", 11));
    CHECK(content(own / "outside.txt") == "left open");
    CHECK(content(own / "printed.txt") == "robot " + id + " says 70000\n");
  }
}

TEST_CASE("robots have the ids that a key says, and loop is called as often") {
  const auto with = [](std::vector<std::string> settings) {
    SwarmOptions options;
    options.settings = std::move(settings);
    return run("id.c", 3, 0.8, options).leds;
  };
  using enum hal::Led;
  CHECK(with({"ode.ids=[10000]", "ode.loops_per_tick=330"}) == std::vector<hal::Led>{red, green, red});
  CHECK(with({"ode.ids=[7, 384, 10001]", "ode.loops_per_tick=330"}) == std::vector<hal::Led>{red, green, green});
  CHECK(with({"ode.ids=[10000]"}) == all(3, off));
  CHECK_THROWS_WITH_AS(with({"ode.ids=[7, 7, 8]"}), doctest::Contains("must be ascending"), hal::ConfigError);
  CHECK_THROWS_WITH_AS(with({"ode.ids=[7, 8]"}), doctest::Contains("must be 3 ids up to 65535"), hal::ConfigError);
  CHECK_THROWS_WITH_AS(with({"ode.ids=[65535]"}), doctest::Contains("must be 3 ids up to 65535"), hal::ConfigError);
}

TEST_CASE("a lab knows robots by their ids") {
  SwarmOptions options;
  options.program = ProgramSources(controller("id.c"));
  options.robots = 2;
  options.settings = {"ode.ids=[383]"};
  ControllerSwarm swarm(options);
  CHECK(swarm.arena().info().robots == std::vector<hal::RobotId>{383, 384});
}

TEST_CASE("names of the robot's C library are there, and registers can be read as they were set") {
  const Ran ran = run("avr_names.c", 1, 1);
  CHECK(ran.printed == "0\n");
  CHECK_THROWS_WITH_AS(
      run("sets_register.c", 1, 1),
      doctest::Contains("sets_register.c:5:9: error: a simulated robot's register OCR2A can only be read"),
      ProgramError);
}

TEST_CASE("a program that repeats something in main() is told what to call, whatever the length of its path") {
  const tests::TemporaryDirectory folder;
  const std::filesystem::path deep = folder.path() / std::string(100, 'd') / "main_loop.c";
  std::filesystem::create_directory(deep.parent_path());
  std::filesystem::copy_file(controller("main_loop.c"), deep);
  SwarmOptions options;
  options.program = ProgramSources(deep);
  std::string sentence;
  try {
    ControllerSwarm swarm(options);
  } catch (const ProgramError& error) {
    sentence = error.what();
  }
  CHECK(sentence.starts_with("the program of robot 0 never calls kilo_start(setup, loop); "));
}

TEST_CASE("what robots print is heard however their program is named") {
  const tests::TemporaryDirectory folder;
  const std::filesystem::path place = folder.path() / "a folder, \xC3\xBC";
  std::filesystem::create_directories(place / "x");
  std::filesystem::copy_file(controller("types.c"), place / "p q.c");
  std::filesystem::create_directory_symlink(place, folder.path() / "link");
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(place);
  for (const std::string path :
       {"p q.c", "./p q.c", "x/../p q.c", "../a folder, \xC3\xBC//p q.c", "../link/p q.c", "."}) {
    CAPTURE(path);
    SwarmOptions options;
    options.program = ProgramSources(std::filesystem::path(path));
    options.robots = 1;
    ControllerSwarm swarm(options);
    swarm.run_until(seconds(1), [](const hal::PoseFrame&) {});
    const auto said = swarm.take_text();
    CHECK((!said.empty() && said.front().text == "0\n"));
  }
  std::filesystem::current_path(before);
}

TEST_CASE("a program is loaded once, and a file refused twice, whatever it is called") {
  const std::filesystem::path plain = controller("types.c"), other = controller("") / "." / "types.c";
  CHECK(RobotProgram::load(ProgramSources(plain)) == RobotProgram::load(ProgramSources(other)));
  ProgramSources twice(plain);
  twice.paths.push_back(other);
  CHECK_THROWS_WITH_AS(files_of(twice), doctest::Contains("is given twice"), ProgramError);
}

TEST_CASE("a part of a program of several files names the file that is missing") {
  const tests::TemporaryDirectory folder;
  std::ofstream(folder.path() / "utility.c") << "void set_motion(int how)\n{ (void)how; }\n";
  std::ofstream(folder.path() / "main.c")
      << "#include <kilolib.h>\nvoid set_motion(int);\nstatic void loop(void) { set_motion(1); }\n"
         "int main(void) { kilo_init(); kilo_start(loop, loop); }\n";
  CHECK_THROWS_WITH_AS(RobotProgram::load(ProgramSources(folder.path() / "main.c")),
                       doctest::Contains("`set_motion` stands in utility.c beside it: give both, or the folder"),
                       ProgramError);
  CHECK_NOTHROW(RobotProgram::load(ProgramSources(folder.path())));
}

TEST_CASE("a run says how many robots did nothing") {
  const Heard heard;
  SwarmOptions options;
  options.program = ProgramSources(controller("id.c"));
  options.robots = 2;
  ControllerSwarm swarm(options);
  swarm.run_until(seconds(11), [](const hal::PoseFrame&) {});
  swarm.arena().end();
  CHECK_MESSAGE(
      heard.says("2 of 2 robots, ids 0 to 1, neither drove, nor sent, nor changed the LED after setup in 11 s"),
      heard.text());
}

TEST_CASE("check and run take the same programs") {
  // Programs put together by chance from what is there for both, and from what neither takes.
  if (std::system("avr-gcc --version > /dev/null 2>&1") != 0) return;
  struct Piece {
    bool good;
    const char *text, *use;
  };
  const Piece pieces[] = {
      {true, "#define BAUD 9600\n#include <util/setbaud.h>\nunsigned divisor(void) { return UBRR_VALUE; }\n",
       "(void)divisor();"},
      {true,
       "#include <stdio.h>\nstatic int put(char c, FILE* to) { (void)c, (void)to; return 0; }\n"
       "FILE serial = FDEV_SETUP_STREAM(put, NULL, _FDEV_SETUP_WRITE);\n",
       "(void)&serial;"},
      {true, "#include <avr/io.h>\nint duty(void) { return OCR2A + OCR2B; }\n", "(void)duty();"},
      {true, "#include <stdlib.h>\nvoid* room(void) { return malloc(20); }\n", "(void)room();"},
      {true, "#include <util/delay.h>\nvoid rest(void) { _delay_ms(5); }\n", "(void)rest();"},
      {true,
       "#include <avr/pgmspace.h>\nstatic const char t[] PROGMEM = \"ab\";\nint b(void) { return pgm_read_byte(t + 1); "
       "}\n",
       "(void)b();"},
      {true,
       "#include <kilombo.h>\ntypedef struct { int n; } USERDATA;\nREGISTER_USERDATA(USERDATA)\n"
       "extern char* (*callback_botinfo)(void);\nvoid tells(void) { callback_botinfo = 0; }\n",
       "(void)tells();"},
      {true,
       "#include <kilombo.h>\n"  // a program's own names for what it sets
       "int16_t callback_obstacles(double x, double y, double* dx, double* dy) { *dx = x, *dy = y; return 1; }\n"
       "int16_t callback_lighting(double x, double y) { return x + y; }\n",
       "SET_CALLBACK(obstacles, callback_obstacles); SET_CALLBACK(lighting, callback_lighting);"},
      {true, "#ifdef KILOBOT\nint on_a_robot(void) { return 1; }\n#endif\n", "(void)0;"},
      {false, "#include <avr/io.h>\nvoid drives(void) { OCR2A = 70; }\n", "(void)drives();"},
      {false, "int unknown(void);\nint calls(void) { return unknown(); }\n", "(void)calls();"},
      {false, "#ifdef KILOBOT\n#error not for a robot\n#endif\n", "(void)0;"},
  };
  hal::RandomStream chance(1, "programs");
  const int programs = tests::thorough() ? 24 : 8;  // each is compiled twice, in seconds
  int taken = 0;
  for (int k = 0; k < programs; ++k) {
    const tests::TemporaryDirectory folder;
    ProgramSources program(folder.path() / "p.c");
    if (chance.below(2)) program.define.push_back("KILOBOT");
    std::string text = "#include <kilolib.h>\n", uses;
    bool good = true;
    for (const Piece& piece : pieces)
      if (chance.below(piece.good ? 2 : 6) == 0) {
        text += piece.text;
        uses += piece.use;
        good &= piece.good || (std::string_view(piece.text).starts_with("#ifdef") && program.define.empty());
      }
    text += "static void setup(void) { " + uses +
            " }\nint main(void) { kilo_init(); kilo_start(setup, setup); return 0; }\n";
    std::ofstream(folder.path() / "p.c") << text;
    CAPTURE(text);
    CAPTURE(program.define.size());
    const auto takes = [&](auto work) {
      try {
        work(program);
        return true;
      } catch (const std::runtime_error&) {
        return false;
      }
    };
    CHECK(takes([](const ProgramSources& sources) { RobotProgram::load(sources); }) == good);
    CHECK(takes([](const ProgramSources& sources) { check_program(sources); }) == good);
    taken += good;
  }
  CHECK((taken > programs / 6 && taken < programs));
}

}  // namespace arkmesh::sim_ode
