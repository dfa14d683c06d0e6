// Builds a robot's program for the robot with avr-gcc and says whether it fits. Runs nothing.
#pragma once

#include <string>
#include <vector>

#include "sim_ode/host/programs/avr_build.hpp"
#include "sim_ode/host/programs/width_warnings.hpp"

namespace arkmesh::sim_ode {

struct CheckedProgram {
  Sizes sizes;                        // static memory; the stack needs what remains
  Frame largest;                      // of the stack, by one function
  std::vector<std::string> warnings;  // of places that depend on how wide an int is, of memory and of counted calls
  bool fits() const { return sizes.flash <= flash_limit_bytes && sizes.ram + largest.bytes <= ram_limit_bytes; }
};

// For AvrBuild: what makes the compiler speak of such places, and what of its words is worth telling.
inline const std::vector<std::string> warning_options = {"-Wtype-limits", "-Wconversion", "-Wsign-compare"};
std::vector<std::string> warnings_in(const std::string& said);

// Throws std::runtime_error with one sentence: no avr-gcc, or the program does not build.
CheckedProgram check_program(const ProgramSources& sources);

}  // namespace arkmesh::sim_ode
