// The robot's compiler and its tools, as commands that build a program for the robot call them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/child_process.hpp"
#include "sim_ode/host/programs/program_sources.hpp"

namespace arkmesh::sim_ode {

// Flash and static memory of a linked program.
struct Sizes {
  int flash = 0, ram = 0;
};

// For avr-gcc: room for more than a robot has, so that what does not fit can be measured too.
inline constexpr const char* link_without_limits =
    "-Wl,--defsym=__TEXT_REGION_LENGTH__=0x100000,--defsym=__DATA_REGION_LENGTH__=0xf000";

// Runs avr-gcc or one of its tools, a minute at most. Throws std::runtime_error with one sentence when it is missing or
// takes longer.
hal::Finished run_avr(std::vector<std::string> command);
// The program's files that are compiled by themselves; the others are parts of these. `words`: the compiler and its
// options for all files. What the compiler cannot read it says when it compiles. Throws std::runtime_error.
std::vector<std::filesystem::path> compiled_alone(const ReadProgram& program, const std::vector<std::string>& words);
// Throws std::runtime_error.
Sizes measured(const std::filesystem::path& elf);

}  // namespace arkmesh::sim_ode
