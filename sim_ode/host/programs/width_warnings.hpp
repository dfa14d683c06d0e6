// What a program computes that a PC does otherwise, or that a simulation does not show, found without running it: in
// avr-gcc's own statements, one operation each and with their types (-fdump-tree-gimple-lineno).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace arkmesh::sim_ode {

// For AvrBuild, whose folder then holds what is read here.
inline const std::vector<std::string> dump_options = {"-fdump-tree-gimple-lineno", "-fstack-usage"};

// What a robot computes otherwise than a PC.
struct Otherwise {
  std::string function, place, what;  // place: "file:line"
  bool fraction = false;
};
struct Widths {
  // Sentences that begin with "file:line: ", of bytes shifted into an int, sums and products of readings in 16 bits,
  // unsigned numbers of 16 bits that are subtracted or compared with negative ones, calls of loop that are counted, and
  // memory that is allocated.
  std::vector<std::string> warnings;
  std::vector<Otherwise> otherwise;               // some of these places, and those of fractions
  std::multimap<std::string, std::string> calls;  // {caller, called}
  // What fits a difference that shows at `place`, "file:line", in `function`: before it there, or in what that calls,
  // but fractions last. `place` may be empty. Null: nothing.
  const Otherwise* near(const std::string& function, const std::string& place) const;
};
// `folder`: an AvrBuild's, built with dump_options and warning_options; `said`: what the compiler said then.
Widths widths_of(const std::filesystem::path& folder, const std::string& said);

struct Frame {
  std::string place, function;  // "file:line"
  int bytes = 0;
};
// The function that takes most of the stack by itself, without those that it calls. Nothing called is 0 bytes.
Frame largest_frame(const std::filesystem::path& folder);

}  // namespace arkmesh::sim_ode
