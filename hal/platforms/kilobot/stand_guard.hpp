// Makes robots stand when the program that drives them is gone, or hangs: a process of its own knows the port and what
// is wanted, and has the program's open line. It opens the line itself when the program has ended, however it ended.
// Else the overhead controller would repeat for ever what it heard last.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "hal/handle.hpp"
#include "hal/time/wall_time.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal::kilobot {

class PortLock;

class StandGuard {
 public:
  // Of the process, as the system shows it.
  static constexpr const char* process_name = "arkmesh-guard";

  struct State {
    FleetCommand::Kind wanted = FleetCommand::Kind::pause;  // a word after which robots stand, for when all is over
    bool all_stand = false;                                 // the line is open, and all robots were seen to stand
    bool ended = false;                                     // in order: nothing is left to do if all stand
    bool said = false;                                      // robots have heard this program
    friend bool operator==(const State&, const State&) = default;
  };

  // Starts program `arkmesh-guard` from the folder of this one, in a session of its own. Where that cannot be, a
  // warning says what it means. A program that has told it something again and again (tell) and then nothing for
  // `hung_after` hangs; 0: never.
  explicit StandGuard(const std::string& port, std::chrono::milliseconds hung_after = std::chrono::seconds(3));
  // The guard does what the last state asks for.
  ~StandGuard() = default;
  StandGuard(const StandGuard&) = delete;
  StandGuard& operator=(const StandGuard&) = delete;

  // The port's lock: others are told when robots have heard the program.
  void keep(std::shared_ptr<PortLock> lock) { lock_ = std::move(lock); }
  // Also a sign of life: to be called from where the program waits. Never blocks.
  void tell(const State& state);
  // The line is open by this descriptor, of which the guard gets a copy; -1: it is closed, and the guard's copy to be.
  void has_line(int descriptor);
  // The program hung, and the guard speaks on the line: it is lost for this program, until has_line(-1).
  bool takes_line();
  // The guard's copy is closed, so that the line can be opened anew.
  bool has_left_line();

 private:
  bool send(const void* bytes, std::size_t n, int descriptor = -1);
  void hear();

  Handle word_;  // closes with this program
  std::shared_ptr<PortLock> lock_;
  std::optional<State> told_;
  TimePoint lived_{};  // when it was last told something
  bool has_line_ = false, takes_line_ = false, leaves_line_ = false;
};

// The guard's own program: hears states on `word` until the other end closes, and acts by the last one. While robots
// were not seen to stand it says the word for up to 60 s, else for less than 3 s; opens the line as often as need be.
// Gives way to a program that wants the port, and begins again when that one ends before its first word. Returns an
// exit code.
int stand_guard(const std::string& port, int word, std::chrono::milliseconds hung_after);

}  // namespace arkmesh::hal::kilobot
