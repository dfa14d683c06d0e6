// One program drives an overhead controller at a time: a lock for each port's name, on this machine, for devices and
// for tcp:// alike. It ends with the process that holds it, whatever happens to that. The lock's file says who has the
// port, and how far that one is: a guard (StandGuard) gives way to a program that wants the port, and comes back when
// that one ends before its first word.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "hal/handle.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"

namespace arkmesh::hal::kilobot {

class StandGuard;

// Who has a port, or had it last, by the words of its lock's file. Anybody may have written them.
struct PortHolder {
  // Trying: it has said nothing to robots yet.
  enum class State : char { trying = 't', speaking = 's', hung = 'h' };
  pid_t process = 0;
  std::string who;
  State state = State::trying;
  bool is_guard() const;
};
// Nothing: no program has had it since the machine was started.
std::optional<PortHolder> port_holder(const std::string& port);
// Notes how far the process that has the port is, for one that knows. No effect when another one has it.
void note_holder(const std::string& port, pid_t process, PortHolder::State state);
// For guards: others are told of one for as long as this is open.
Handle stand_by(const std::string& port);

class PortLock {
 public:
  // `who`: named to others that want the port, such as "lab shark". A guard that has the port gives way within moments.
  // Throws PortError when another program has it.
  PortLock(const std::string& port, const std::string& who);

  // Where the port's name leads to now is locked: a device that was plugged in again may be another one. Throws as the
  // constructor.
  void follow();
  // The robots have heard this program: a guard that gave way to it leaves.
  void take_over() { write(PortHolder::State::speaking); }
  // Who had the port before, when this is a guard's: it says so with its first write().
  PortHolder former() const;
  void write(PortHolder::State state) const;
  // For guards: the port is free, and is_wanted() still tells.
  void release() const;
  // For guards: another program wants the port.
  bool is_wanted() const;
  // The end of a sentence about a try that has failed: who tells the robots to stand now; empty: nobody does.
  std::string guarded_words() const;

 private:
  void lock();

  std::string port_, who_, path_;
  pid_t process_;
  Handle file_;
};

// A stream to what find_line() takes, for this program alone for as long as it lives. Throws PortError. `lock`: of the
// stream, which keeps it. `guard`: of a program that has one.
std::unique_ptr<ByteStream> claim_byte_stream(const std::string& port, const std::string& who,
                                              std::shared_ptr<PortLock>* lock = nullptr,
                                              std::shared_ptr<StandGuard> guard = nullptr);

}  // namespace arkmesh::hal::kilobot
