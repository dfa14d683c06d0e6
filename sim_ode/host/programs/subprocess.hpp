// Runs another program to its end and collects what it printed. For compilers and symbol tools; never inside a run's
// time.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace arkmesh::sim_ode {

struct Finished {
  int status = -1;  // exit status; -1: it could not be started or was killed
  bool too_long = false;
  std::string output;  // standard output and error together, at most 64 KiB
};

// Looks `command[0]` up in PATH. Standard input is empty. After `limit` it is killed with all that it started.
Finished run_to_end(const std::vector<std::string>& command, std::chrono::milliseconds limit = std::chrono::minutes(1));

// A script that comes with arkmesh: in share/arkmesh of an installed program, or among the sources.
std::filesystem::path script_of_arkmesh(const std::string& name);

}  // namespace arkmesh::sim_ode
