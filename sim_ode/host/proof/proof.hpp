// Runs a program on the robot's own processor, in an emulator, with what simulated robots got, and says what differs.
#pragma once

#include <string>
#include <vector>

#include "sim_ode/host/programs/program_sources.hpp"
#include "sim_ode/host/turns/turn_log.hpp"

namespace arkmesh::sim_ode {

struct Proof {
  std::vector<std::string> causes;  // of differences, a sentence each, in the order in which they were found
  std::vector<std::string> notes;   // likewise, of fractions that differ in no output
  std::string figures;              // memory and time that the program took, one sentence
  std::string not_compared;         // variables, if any, one sentence
};

// `log` is of simulated robots that ran the program. Throws std::runtime_error with one sentence: it does not build, or
// tools are missing.
Proof prove_program(const ProgramSources& sources, const TurnLog& log);

}  // namespace arkmesh::sim_ode
