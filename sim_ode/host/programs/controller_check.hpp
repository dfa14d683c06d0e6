// Builds a robot's program for the robot with avr-gcc and says whether it fits. Runs nothing.
#pragma once

#include <string>
#include <vector>

#include "sim_ode/host/programs/program_sources.hpp"

namespace arkmesh::sim_ode {

// What the boot loader leaves, and what the robot's library itself takes of it (a program with empty setup and loop).
inline constexpr int flash_limit_bytes = 28160, flash_library_bytes = 7054;
inline constexpr int ram_limit_bytes = 2048, ram_library_bytes = 110;

struct CheckedProgram {
  int flash_bytes = 0;                // program and library
  int ram_bytes = 0;                  // static, program and library; the stack needs what remains
  std::vector<std::string> warnings;  // of places that depend on how wide an int is
  bool fits() const { return flash_bytes <= flash_limit_bytes && ram_bytes <= ram_limit_bytes; }
};

// Throws std::runtime_error with one sentence: no avr-gcc, or the program does not build.
CheckedProgram check_program(const ProgramSources& sources);

}  // namespace arkmesh::sim_ode
