// The one way to start a program: as a child of this process, which it does not outlive.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hal/handle.hpp"

namespace arkmesh::hal {

struct ChildStart {
  std::vector<std::string> command = {};      // its first word is looked up in PATH
  std::vector<std::string> environment = {};  // of the command: NAME=VALUE beside those of this process
  std::function<int()> function =
      {};                     // in place of a command, in a copy of this process; its exit code. Must not throw
  bool own_group = true;      // Ctrl-C does not reach it, and what it starts ends with it
  bool keeps_errors = true;   // its standard error is output, too; else it is ours
  bool has_line = false;      // its descriptor 3 is the other end of line()
  int last_signal = SIGKILL;  // what it gets when the thread that started it ends
  std::chrono::seconds processor_time{0};  // after which it gets SIGXCPU, and each that it starts; 0: no limit
};

// Its standard input is empty.
class ChildProcess {
 public:
  // Throws std::runtime_error with one sentence.
  explicit ChildProcess(ChildStart start);
  ~ChildProcess();  // kills it, and all of its group
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  struct End {
    int code = 0;    // 127: the command could not be started; 128 + signal when a signal ended it
    int signal = 0;  // 0: it ended by itself
  };
  // How it has ended; nothing while it runs.
  std::optional<End> end() const { return look(true); }
  // Waits until it has.
  End wait() const { return *look(false); }
  // How long it has waited for a processor that others had; 0 where the kernel does not count that.
  std::chrono::nanoseconds run_delay() const;
  pid_t id() const { return id_; }
  // Of a child that has not been waited for the number stays its own, so this reaches nobody else. Never its group.
  void signal(int number) const { ::kill(id_, number); }

  // Appends what it has said, at most 64 KiB, and waits for nothing. False: it has closed its output.
  bool read(std::string& text);
  // To be polled; -1 after it has closed it.
  int output() const { return output_.get(); }
  // Does not block. Stays this object's.
  int line() const { return line_.get(); }
  // For another child, which is a copy of this process and has no business with this one's output.
  void close_output() { output_ = Handle(); }

 private:
  std::optional<End> look(bool at_once) const;

  pid_t id_ = -1;
  bool own_group_;
  Handle output_, line_;
};

struct Finished {
  int status = -1;  // exit status, 127 when it could not be started; -1: it was killed
  bool too_long = false;
  std::string output;  // at most 64 KiB
};

// Runs a child to its end and collects what it says. After `limit` it is killed, with all that it started. What
// must not be ended because the machine is busy gets a long limit, and a short one of processor time.
Finished run_to_end(ChildStart start, std::optional<std::chrono::milliseconds> limit = std::chrono::minutes(1));

}  // namespace arkmesh::hal
