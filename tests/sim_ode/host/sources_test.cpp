// Programs of several C files, with headers of folders beside them and macros.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "sim_ode/controller_swarm.hpp"
#include "sim_ode/host/programs/controller_check.hpp"
#include "sim_ode/host/programs/object_build.hpp"
#include "tests/sim_ode/arena_builder.hpp"
#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

ProgramSources several() {
  ProgramSources out(controller("several"));
  out.include = {controller("common")};
  out.define = {"SHOWN=3"};
  return out;
}

// What a program is refused with.
std::string refused(const ProgramSources& program) {
  try {
    RobotProgram::load(program);
  } catch (const ProgramError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a program of several files runs, each robot with its own static variables") {
  ProgramSources one_by_one = several();
  one_by_one.paths.clear();
  for (const char* file : {"listen.c", "list.c", "main.c"}) one_by_one.paths.push_back(controller("several") / file);
  for (const ProgramSources& program : {several(), one_by_one}) {
    ControllerSwarm swarm({.program = program, .robots = 5});
    const auto all_show = [&](hal::Led led) {
      return [led](const hal::PoseFrame& frame) {
        for (const hal::Observation& robot : frame.robots) CHECK(robot.led == led);
      };
    };
    swarm.run_until(seconds(1), all_show(hal::Led::off));
    swarm.arena().robots().command(broadcast(9, {1}));
    swarm.run_until(seconds(1.1), [](const hal::PoseFrame&) {});
    swarm.run_until(seconds(2), all_show(hal::Led::green));
  }
}

TEST_CASE("a lab's file names several files, folders of headers and macros") {
  const fs::path folder = controller("several");
  const auto with = [&](const std::string& ode) {
    const auto config = hal::Config::from_text(
        fmt::format("[arena]\nrobots = 1\n[arena.ode]\ncontroller = \"{}\"\n{}\n", folder.string(), ode), "test.toml");
    const hal::Section section = config.root().section("arena");
    make_ode_arena(section, "shark", 1);
    return program_files(section);
  };
  const std::string include = fmt::format("include = \"{}\"\n", controller("common").string());
  // With the headers that they include, each once.
  const std::vector<fs::path> files = with(include + "define = [\"SHOWN=1\"]");
  CHECK(files.size() == 5);
  for (const fs::path& file : {folder / "list.c", folder / "listen.c", folder / "main.c", folder / "list.h",
                               fs::path(controller("common")) / "colour.h"})
    CHECK(std::ranges::count(files, file) == 1);
  CHECK_THROWS_WITH_AS(with(include), doctest::Contains("give SHOWN"), hal::ConfigError);
  CHECK_THROWS_WITH_AS(with("define = [\"SHOWN=1\"]"), doctest::Contains("main.c:4:10: fatal error: colour.h"),
                       hal::ConfigError);
  CHECK_THROWS_WITH_AS(with("define = [\"3=1\"]"),
                       doctest::Contains("arena.ode.define = [ \"3=1\" ]: \"3=1\" is not a macro; write NAME"),
                       hal::ConfigError);
}

TEST_CASE("a program is called by its first file or folder") {
  CHECK(ProgramSources(fs::path("/a/b.c")).name() == "b.c");
  CHECK(ProgramSources(fs::path("/a/several/")).name() == "several");
  CHECK(ProgramSources(fs::path("/a/several/.")).name() == "several");
  CHECK(ProgramSources(fs::path("b.c")).name() == "b.c");
}

TEST_CASE("a file that another one includes is compiled there only") {
  const tests::TemporaryDirectory folder;
  folder.write("part.c", "static int n;\nvoid more() { n++; }\n");
  folder.write(
      "whole.c",
      "#include <kilolib.h>\n#include \"part.c\"\nvoid loop() { more(); set_color(n > 1 ? RGB(0, 3, 0) : 0); }\n"
      "int main() { kilo_init(); kilo_start(more, loop); }\n");
  ControllerSwarm swarm({.program = folder.path(), .robots = 2});
  swarm.run_until(seconds(1), [](const hal::PoseFrame& frame) {
    if (frame.number == 10)
      for (const hal::Observation& robot : frame.robots) CHECK(robot.led == hal::Led::green);
  });
  if (std::system("avr-gcc --version > /dev/null 2>&1") == 0) CHECK(check_program(folder.path()).fits());
}

TEST_CASE("what does not go together is named with its file and line") {
  const tests::TemporaryDirectory folder;
  const fs::path first = folder.write("a.c",
                                      "#include <kilolib.h>\nvoid other();\nvoid f() { other(); }\n"
                                      "int main() { kilo_init(); kilo_start(f, f); }\n"),
                 second = folder.write("b.c", "int main() { return 1; }\nvoid other() {}\n");
  CHECK(refused(first).find("a.c:3: undefined reference to `other'") != std::string::npos);
  ProgramSources both;
  both.paths = {first, second};
  CHECK(refused(both).find("b.c:1: multiple definition of `main'") != std::string::npos);
  both.paths = {first, first};
  CHECK(refused(both) == fmt::format("{} is given twice; name each file once", first.string()));
  folder.write("empty/readme.txt", "");
  const fs::path empty = folder.path() / "empty";
  CHECK(refused(empty) == fmt::format("{} holds no C file; name another folder", empty.string()));
  CHECK(refused(folder.path() / "none.c").ends_with("cannot be read; name a C file"));
}

TEST_CASE("a program of several files is checked for the robot") {
  if (std::system("avr-gcc --version > /dev/null 2>&1") != 0) {
    MESSAGE("avr-gcc is not installed: the build for the robot is not checked");
    return;
  }
  const CheckedProgram checked = check_program(several());
  CHECK(checked.fits());
  CHECK(checked.sizes.ram >= ram_library_bytes + 45);  // the list, its length, rounds, heard
  ProgramSources wrong = several();
  wrong.define.clear();
  CHECK_THROWS_WITH(check_program(wrong), doctest::Contains("give SHOWN"));
}

}  // namespace arkmesh::sim_ode
