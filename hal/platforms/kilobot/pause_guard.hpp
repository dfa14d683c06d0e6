// Pauses the robots of a program that is killed: a process of its own shares the program's line to the overhead
// controller, and speaks when the program is gone without a word. Else the controller would repeat for ever what it
// heard last.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <memory>

#include "hal/handle.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"

namespace arkmesh::hal::kilobot {

// For how long a guard has the line after its program, when the line takes what it says.
constexpr std::chrono::milliseconds guard_speaks_at_most{2'000};

class PauseGuard {
 public:
  // Forks the process. `line` is the descriptor of an open line. Where no process can be made, a warning says what that
  // means.
  explicit PauseGuard(int line);
  // Sends the process away; afterwards it does not hold the line any more.
  ~PauseGuard();
  PauseGuard(const PauseGuard&) = delete;
  PauseGuard& operator=(const PauseGuard&) = delete;

 private:
  Handle word_;  // what is written to it is the word; it closes with this program
  pid_t process_ = -1;
};

// `stream` with a guard while it is open, from now on if it is open now.
std::unique_ptr<ByteStream> guarded(std::unique_ptr<ByteStream> stream);

}  // namespace arkmesh::hal::kilobot
