// What `arkmesh lab` does, for commands that run a lab as it does and more.
#pragma once

#include <string>
#include <vector>

namespace arkmesh::cli {

struct LabOptions {
  std::string file, out;  // of the lab; the results' folder, empty: runs/DATE-TIME-LAB
  std::vector<std::string> sets;
  bool force = false, open = false;
};

// Runs the lab to its end. Returns the exit code.
int run_lab(const LabOptions& options);

}  // namespace arkmesh::cli
