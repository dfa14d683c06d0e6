// Where what robots say goes, beside the air.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace arkmesh::sim_ode {

class ProgramText;
class TurnLog;

struct RobotOutput {
  ProgramText* text = nullptr;     // what they print, for whoever takes it; outlives the robots
  TurnLog* log = nullptr;          // of all that happens to their programs; outlives the robots
  std::filesystem::path folder;    // of their files, and of what they print when nobody takes it; empty: they have none
  std::vector<std::string> names;  // of robots' folders in it; empty: 0, 1, 2, ...
};

}  // namespace arkmesh::sim_ode
