// What a program computes that a PC does otherwise, or that a simulation does not show, found without running it: in
// avr-gcc's own statements, one operation each and with their types (-fdump-tree-gimple-lineno).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace arkmesh::sim_ode {

// For AvrBuild, whose folder then holds what is read here.
inline const std::vector<std::string> dump_options = {"-fdump-tree-gimple-lineno", "-fstack-usage"};

// Sentences that begin with "file:line: ", of bytes shifted into an int, sums and products of readings in 16 bits,
// calls of loop that are counted, and memory that is allocated. `folder`: an AvrBuild's, built with dump_options.
std::vector<std::string> width_warnings(const std::filesystem::path& folder);

struct Frame {
  std::string place, function;  // "file:line"
  int bytes = 0;
};
// The function that takes most of the stack by itself, without those that it calls. Nothing called is 0 bytes.
Frame largest_frame(const std::filesystem::path& folder);

}  // namespace arkmesh::sim_ode
