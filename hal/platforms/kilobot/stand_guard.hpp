// Makes robots stand when the program that drives them is gone: a process of its own knows the port and what is wanted,
// and opens the line itself when the program has ended, however it ended. Else the overhead controller would repeat for
// ever what it heard last.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

#include "hal/handle.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal::kilobot {

class StandGuard {
 public:
  // Of the process, as the system shows it.
  static constexpr const char* process_name = "arkmesh-guard";

  struct State {
    FleetCommand::Kind wanted = FleetCommand::Kind::pause;  // a word after which robots stand, for when all is over
    bool all_stand = false;                                 // the line is open, and all robots were seen to stand
    bool ended = false;                                     // in order: nothing is left to do if all stand
    friend bool operator==(const State&, const State&) = default;
  };

  // Starts program `arkmesh-guard` from the folder of this one, in a session of its own. Where that cannot be, a
  // warning says what it means.
  explicit StandGuard(const std::string& port);
  // The guard does what the last state asks for.
  ~StandGuard() = default;
  StandGuard(const StandGuard&) = delete;
  StandGuard& operator=(const StandGuard&) = delete;

  // Never blocks. What was told already is not told again.
  void tell(const State& state);

 private:
  Handle word_;  // closes with this program
  std::optional<State> told_;
};

// The guard's own program: hears states on `word` until the other end closes, and acts by the last one. While robots
// were not seen to stand it says the word for up to 60 s, else for less than 3 s; opens the line as often as need be.
// Leaves at once when a program wants the port (SIGTERM), or has it. Returns an exit code.
int stand_guard(const std::string& port, int word);

}  // namespace arkmesh::hal::kilobot
