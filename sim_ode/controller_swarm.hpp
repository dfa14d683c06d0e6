// Robots that run one program, alone in a simulated arena: what `arkmesh controller run` shows and tests of programs
// look at.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/config/config.hpp"
#include "sim_ode/host/programs/program_text.hpp"
#include "sim_ode/host/programs/robot_program.hpp"

namespace arkmesh::sim_ode {

class TurnLog;

struct SwarmOptions {
  ProgramSources program;
  int robots = 25;
  double width_m = 1, height_m = 1;
  std::uint64_t seed = 1;
  std::optional<hal::Pose> light;  // place of a lamp; its heading means nothing
  double spacing_m = 0;            // 0: robots start at random places; else on a square grid round the arena's centre
  std::vector<hal::Pose> places;   // of all robots, instead of the above; empty: not used
  bool hostile = false;            // robots also receive what HostileAir makes
  TurnLog* log = nullptr;          // of what happens to robots' programs; outlives the swarm
  std::filesystem::path robots_folder;  // of files that robots open; empty: they cannot
  std::vector<std::string> settings;    // further keys of the arena, "ode.friction=0"
};

class ControllerSwarm {
 public:
  // Compiles the program, puts the robots in place and tells them to run. Throws sim_ode::ProgramError when it is the
  // program's fault, hal::ConfigError when the options do not go together.
  explicit ControllerSwarm(const SwarmOptions& options);

  // Lab time passes until `end`; each frame, 10 a second, is handed to `look`. Throws std::runtime_error with one
  // sentence when a robot's program crashes or never returns.
  void run_until(hal::LabTime end, const std::function<void(const hal::PoseFrame&)>& look);

  // What robots printed since the last call, and how many characters were lost in all because nobody called.
  std::vector<sim_ode::ProgramText::Piece> take_text() { return text_.take(); }
  std::uint64_t lost_text() const { return text_.lost(); }

  hal::Arena& arena() { return *arena_; }
  const hal::Arena& arena() const { return *arena_; }

 private:
  std::shared_ptr<const sim_ode::RobotProgram> program_;
  sim_ode::ProgramText text_;
  std::unique_ptr<hal::Arena> arena_;
  hal::LabTime next_{0};  // of the next frame
};

}  // namespace arkmesh::sim_ode
