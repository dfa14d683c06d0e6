// Every program of this folder on 25 robots for a minute: what runs, what is refused, what crashes, and how it is told.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>

#include "hal/overlay/led_name.hpp"
#include "sim_ode/host/programs/controller_check.hpp"
#include "tests/sim_ode/host/program_run.hpp"
#include "tests/support/processes/thorough.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;
using hal::Led;

namespace {

enum class End { runs, fails, refused };

struct Expected {
  std::string program;
  End end = End::runs;
  std::vector<std::string> says = {};  // parts of the sentence of a program that does not run
  std::optional<Led> all_show = {};    // at the end, of a program that checks itself: every robot shows this
  bool moves = false;                  // robots get anywhere; none does in the others
  bool talks = false;                  // messages are sent and heard; none are in the others
};

// Robots stand so near that everybody hears somebody.
SwarmProgram near_each_other(const std::string& program) {
  SwarmProgram run(program);
  run.options.width_m = run.options.height_m = 0.4;
  return run;
}

const std::vector<Expected>& table() {
  constexpr Led green = Led::green;
  static const std::vector<Expected> rows = {
      {"labs_blink"},
      {.program = "labs_move", .moves = true},
      {.program = "labs_talk", .talks = true},
      {.program = "labs_distance", .talks = true},
      {.program = "labs_random_walk", .moves = true},
      {.program = "labs_battery", .all_show = green},
      {.program = "labs_drive", .moves = true},
      {.program = "labs_drive_all", .all_show = Led::blue, .moves = true},
      {.program = "gradient_hops", .talks = true},
      {.program = "orbit_planet", .moves = true, .talks = true},
      {.program = "sync_firefly", .talks = true},
      {.program = "sync_clock", .talks = true},
      {.program = "phototaxis_zigzag", .moves = true},
      {.program = "phototaxis_hide", .moves = true},
      {.program = "disperse_simple", .moves = true, .talks = true},
      {.program = "naming_game", .talks = true},
      {.program = "ark_blocks", .all_show = Led::off},
      {.program = "ark_gossip", .all_show = Led::off},
      {.program = "buffered_chat", .all_show = green, .talks = true},
      {.program = "style_own_names", .all_show = green},
      {.program = "style_libc_names", .all_show = green},
      {.program = "style_no_return", .all_show = green, .talks = true},
      {.program = "style_parts", .all_show = green},
      {"style_busy_clock"},
      {"style_busy_sensor"},
      {.program = "style_spin_flag", .talks = true},
      {"style_clock_write"},
      {.program = "style_random", .all_show = green, .moves = true},
      {.program = "style_statics", .all_show = green},
      {.program = "style_text", .all_show = green},
      {.program = "style_silent_text", .all_show = green},
      {.program = "style_calibration", .all_show = green, .moves = true},
      {.program = "layout_8_16", .all_show = Led::off},
      {.program = "layout_7_17", .all_show = Led::off},
      {.program = "layout_7_1_16", .all_show = Led::off},
      {.program = "layout_whole", .all_show = Led::off},
      {.program = "art_callback_delay", .talks = true},
      {.program = "style_state_table", .all_show = green, .talks = true},
      {.program = "style_tx_zero", .all_show = green, .talks = true},
      {.program = "style_math_names", .all_show = green},
      {.program = "style_own_maths", .all_show = green},
      {.program = "style_gnu", .all_show = green},
      {.program = "style_inline", .all_show = green},
      {.program = "style_pgm", .all_show = green},
      {.program = "style_eeprom", .all_show = green},
      {.program = "style_registers", .all_show = green},
      {.program = "style_avr_text", .all_show = green},
      {.program = "style_k_and_r", .all_show = green},
      {.program = "style_wait_plain", .talks = true},
      {.program = "style_wait_include", .all_show = green, .talks = true},
      {.program = "style_wait_lonely", .all_show = Led::blue},
      {.program = "style_packed", .all_show = green, .talks = true},
      {.program = "style_overflow", .all_show = green},
      {.program = "style_clock_field", .all_show = green},
      {.program = "style_clock_again", .all_show = green},
      {.program = "mute_no_crc", .all_show = Led::red},
      {.program = "count_sends", .talks = true},
      {"crash_null", End::fails, {"robot 3 ", "bad pointer", "crash_null.c:10", " s"}},
      {"crash_stack", End::fails, {"stack overflow", "crash_stack.c:4"}},
      {"crash_tail", End::fails, {"division by zero", "in inner", "crash_tail.c:6"}},
      {"crash_after_delay", End::fails, {"robot 2 ", "bad pointer", "crash_after_delay.c:11", "3.066 s"}},
      {"crash_assert", End::fails, {"robot 1 ", "kilo_uid != 1", "crash_assert.c:7"}},
      {"hang_loop", End::fails, {"never returns", "hang_loop.c:9"}},
      {"hang_setup", End::fails, {"never returns", "hang_setup.c:5"}},
      {"hang_callback", End::fails, {"never returns", "hang_callback.c:7"}},
      {"refused_registers", End::refused, {"refused_registers.c:6", "register OCR2A can only be read"}},
      {"refused_syntax", End::refused, {"does not compile", "refused_syntax.c:7", "error"}},
      {"refused_unknown", End::refused, {"dance_wildly", "refused_unknown.c:7"}},
      {"refused_no_start", End::refused, {"never calls kilo_start"}},
  };
  return rows;
}

void check_outcome(const Expected& expected, const SwarmProgram& run) {
  if (expected.end != End::runs) {
    CHECK(run.refused == (expected.end == End::refused));
    CHECK_FALSE(run.failure.empty());
    CHECK(run.failure.find('\n') == std::string::npos);
    for (const std::string& part : expected.says)
      CHECK_MESSAGE(run.failure.find(part) != std::string::npos, part, " in: ", run.failure);
    return;
  }
  CHECK_MESSAGE(run.failure.empty(), run.failure);
  REQUIRE(run.report.last().robots.size() == 25);
  CHECK(run.report.last().stamp == hal::LabTime(60'000'000));
  double path_m = 0;
  for (const double p : run.report.path_m()) path_m += p;
  CHECK((path_m > 0.02) == expected.moves);
  CHECK((run.count("infrared.sent") > 25) == (expected.talks || expected.program == "mute_no_crc"));
  CHECK((run.count("infrared.received") > 0) == expected.talks);
  if (expected.all_show)
    for (const hal::Observation& robot : run.report.last().robots)
      CHECK_MESSAGE(robot.led == *expected.all_show, "robot ", robot.robot, " shows ",
                    std::string(hal::name_of(robot.led)));
}

}  // namespace

TEST_CASE("every program has the outcome that the table names") {
  // Programs as other people write them run unmodified; those that fail are told in one sentence with robot, time and
  // line. One in seven, if not thorough.
  std::set<std::string> seen;
  for (const Expected& expected : table()) {
    CAPTURE(expected.program);
    seen.insert(expected.program);
    if (!arkmesh::tests::thorough() && seen.size() % 7 != 0) continue;
    SwarmProgram run = near_each_other(expected.program);
    run.for_seconds(60);
    check_outcome(expected, run);
  }
  for (const auto& entry : std::filesystem::directory_iterator(programs_folder()))
    if (entry.path().extension() == ".c")
      CHECK_MESSAGE(seen.contains(entry.path().stem().string()), entry.path().filename().string());
}

TEST_CASE("the same seed gives the same swarm, another seed another one") {
  // Programs that wait in delay(), in callbacks, on the clock or for a flag, that crash or hang in one robot, that
  // print, or draw random numbers repeat frame for frame. Every other one, if not thorough.
  int number = 0;
  for (const std::string program :
       {"style_busy_clock", "labs_move", "naming_game", "style_random", "crash_after_delay", "style_wait_plain",
        "style_wait_include", "crash_null", "crash_tail", "art_callback_delay", "hang_callback", "style_text"}) {
    CAPTURE(program);
    if (!arkmesh::tests::thorough() && ++number % 2 == 0) continue;
    SwarmProgram first = near_each_other(program), second = near_each_other(program), third = near_each_other(program);
    third.options.seed = 2;
    for (SwarmProgram* run : {&first, &second, &third}) run->for_seconds(20);
    CHECK(first.hash == second.hash);
    CHECK(first.failure == second.failure);
    CHECK(first.hash != third.hash);
  }
}

TEST_CASE("programs fit on a robot, and those that do not build for it are refused in one sentence") {
  // The files that the simulator runs are the files that the robot's own compiler builds.
  if (std::system("avr-gcc --version > /dev/null 2>&1") != 0) {
    MESSAGE("avr-gcc is not installed: the build for the robot is not checked");
    return;
  }
  std::set<std::string> refused = {"refused_registers", "refused_syntax", "refused_unknown"};
  // Old C, which avr-gcc takes for wrong from version 14 on.
  if (std::system("avr-gcc -dumpversion | grep -qE '^(1[4-9]|[2-9][0-9])'") == 0)
    refused.insert({"style_clock_again", "style_k_and_r", "style_pgm"});
  for (std::size_t i = 0; i < table().size(); i += arkmesh::tests::thorough() ? 1 : 5) {
    const Expected& expected = table()[i];
    CAPTURE(expected.program);
    const bool builds = !refused.contains(expected.program);
    if (!builds) {
      CHECK_THROWS_AS(sim_ode::check_program(program_file(expected.program)), std::runtime_error);
      continue;
    }
    const sim_ode::CheckedProgram checked = sim_ode::check_program(program_file(expected.program));
    CHECK(checked.fits() == (expected.program != "crash_stack"));
    CHECK(checked.sizes.flash > sim_ode::flash_library_bytes - 100);
    CHECK(checked.sizes.flash < 13000);  // one makes text of fractions
    CHECK(checked.sizes.ram >= sim_ode::ram_library_bytes);
    CHECK(checked.sizes.ram < 500);
  }
}
