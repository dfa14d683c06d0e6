// Programs on the robot's own processor, emulated, beside simulated robots: what is the same is called the same, and
// each cause of a difference is found and named.
#include "sim_ode/host/proof/proof.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "tests/sim_ode/host/program_run.hpp"
#include "tests/support/processes/thorough.hpp"

namespace arkmesh::tests {
namespace {

bool can_prove() {
  const bool can = std::system("avr-gcc --version > /dev/null 2>&1") == 0 &&
                   std::filesystem::exists("/usr/include/simavr/sim_avr.h");
  if (!can) MESSAGE("avr-gcc or simavr is not installed: nothing is proved");
  return can;
}

sim_ode::Proof proof_of(const std::filesystem::path& program, int robots, double seconds, bool hostile = false) {
  sim_ode::TurnLog log(robots);
  sim_ode::SwarmOptions options;
  options.program = program;
  options.robots = robots;
  options.width_m = options.height_m = 0.5;
  options.light = hal::Pose{.x_m = 0.1};
  options.log = &log;
  options.hostile = hostile;
  sim_ode::ControllerSwarm swarm(options);
  swarm.run_until(hal::LabTime(static_cast<std::int64_t>(seconds * 1e6)), [](const hal::PoseFrame&) {});
  return sim_ode::prove_program(options.program, log);
}

}  // namespace

TEST_CASE("a proof without a robot is refused, for nothing was compared") {
  if (!can_prove()) return;
  CHECK_THROWS_WITH(sim_ode::prove_program(programs_folder() / "differs" / "same.c", sim_ode::TurnLog(0)),
                    "no robot ran, so nothing was compared");
}

TEST_CASE("each cause of a difference is found, with its line and what it does to an output") {
  // One program for each cause; words of the sentence that names it.
  if (!can_prove()) return;
  const struct {
    const char* program;
    double seconds;
    std::vector<std::string> words;
  } table[] = {
      {"overflow", 5, {"average is ", "in loop (overflow.c:6)", "overflows a 16-bit int at line 6", "set_motors("}},
      {"shifted",
       10,
       {"last_id is 4294", "(shifted.c:7)", "a shift loses bits", "at line 7", "set_color(3) on a robot"}},
      {"wrapped",
       1,
       {"late is 65436 on a robot and -100 here", "(wrapped.c:7)", "16-bit unsigned numbers wrap around",
        "set_color("}},
      {"compared",
       1,
       {"again is 1 on a robot and 0 here, set in light (compared.c:6)", "a negative number is compared", "(line 6)",
        "set_color("}},
      {"fraction",
       12,
       {"level is 7 on a robot and 8 here", "(fraction.c:8)", "floating-point numbers", "first seen at tick"}},
      {"index", 10, {"set_color(", "in hear (index.c:9)", "an index is beyond its array at line 9"}},
      {"unset", 2, {"message ", "197 197 197", "the program never sets it"}},
      {"memory", 12, {"static memory, heap and stack exceed a robot's 2048 bytes"}},
      {"long_loop", 1, {"loop takes ", " ticks, and no time here"}},
  };
  for (const auto& row : table) {
    const sim_ode::Proof proof =
        proof_of(programs_folder() / "differs" / fmt::format("{}.c", row.program), 6, row.seconds);
    REQUIRE_MESSAGE(!proof.causes.empty(), row.program);
    for (const std::string& word : row.words)
      CHECK_MESSAGE(proof.causes[0].find(word) != std::string::npos, row.program, ": ", proof.causes[0], " lacks ",
                    word);
    // a cause is told once, and hides no other
    CHECK_MESSAGE(proof.causes.size() <= 2, fmt::format("{}", fmt::join(proof.causes, "\n")));
  }
  const sim_ode::Proof busy = proof_of(programs_folder() / "differs" / "busy.c", 6, 10);
  CHECK_MESSAGE(busy.causes.empty(), fmt::format("{}", fmt::join(busy.causes, "\n")));
  // reads the clock in a loop, also while its lowest byte begins anew: at tick 768
  const sim_ode::Proof clock = proof_of(programs_folder() / "style_busy_clock.c", 12, 26);
  CHECK_MESSAGE(clock.causes.empty(), fmt::format("{}", fmt::join(clock.causes, "\n")));
  // the same on both sides, and a warning
  const sim_ode::Proof sign = proof_of(programs_folder() / "differs" / "sign.c", 2, 5);
  CHECK(sign.causes.empty());
  REQUIRE(sign.notes.size() == 1);
  CHECK(sign.notes[0].find("sign.c:6") != std::string::npos);
}

TEST_CASE("messages that nobody of the swarm sends find what the swarm's own do not") {
  if (!can_prove()) return;
  const std::filesystem::path program = programs_folder() / "differs" / "unasked.c";
  CHECK(proof_of(program, 6, 5).causes.empty());
  const sim_ode::Proof proof = proof_of(program, 6, 5, true);
  REQUIRE(!proof.causes.empty());
  CHECK_MESSAGE(proof.causes[0].find("an index is beyond its array at line 7") != std::string::npos, proof.causes[0]);
  // and a program that looks first stands them
  const sim_ode::Proof same = proof_of(programs_folder() / "differs" / "same.c", 6, 8, true);
  CHECK_MESSAGE(same.causes.empty(), fmt::format("{}", fmt::join(same.causes, "\n")));
}

TEST_CASE("programs that do the same are called the same, in messages, waits, readings, fractions and the EEPROM") {
  if (!can_prove()) return;
  // reads a register that counts, which no log has
  const std::set<std::string> other = {"style_registers"};
  std::vector<std::filesystem::path> programs = {programs_folder() / "differs" / "same.c"};
  for (const auto& entry : std::filesystem::directory_iterator(programs_folder())) {
    const std::string name = entry.path().stem().string();
    const auto begins = [&](const char* with) { return name.starts_with(with); };
    if (entry.path().extension() == ".c" && !other.contains(name) && !begins("crash_") && !begins("hang_") &&
        !begins("refused_"))
      programs.push_back(entry.path());
  }
  std::sort(programs.begin() + 1, programs.end());
  for (std::size_t i = 0; i < programs.size(); i += thorough() ? 1 : 9) {
    const sim_ode::Proof proof = proof_of(programs[i], thorough() ? 12 : 4, thorough() ? 60 : 8);
    CHECK_MESSAGE(proof.causes.empty(), programs[i], fmt::format("\n{}", fmt::join(proof.causes, "\n")));
  }
}

}  // namespace arkmesh::tests
