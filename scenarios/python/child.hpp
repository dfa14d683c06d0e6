// A child process at the other end of a socket pair: messages both ways, and what it prints, both bounded. The child is
// in a group of its own, so Ctrl-C does not reach it, and it does not outlive this object or this process.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/child_process.hpp"
#include "scenarios/python/one_processor.hpp"

namespace arkmesh::scenarios::python {

struct Message {
  char kind = 0;
  std::string content;
};

class Child {
 public:
  static constexpr std::size_t max_message = 64u << 20, max_output = 256u << 10;  // bytes

  // Looks `command[0]` up in PATH; `environment` holds NAME=VALUE beside those of this process. The child has its end
  // of the socket pair as descriptor 3. Throws std::runtime_error with one sentence.
  Child(std::vector<std::string> command, std::vector<std::string> environment);

  // Never blocks: what does not fit goes out in later calls of receive.
  void send(char kind, std::string_view content);
  // The child's next message; waits for it at most so long. None: not there yet, or a signal came. Throws
  // std::runtime_error with the end of a sentence ("was killed by signal 9") when it is gone or says what is too long.
  std::optional<Message> receive(std::chrono::milliseconds wait);
  // What it has printed since the last call. After max_output bytes the rest is dropped and counted.
  std::string take_output();
  std::uint64_t dropped_output() const { return dropped_; }
  // It owes an answer from now on.
  void begin_to_wait();
  // That answer has come. Not to be called where the lab keeps real time: see OneProcessor.
  void has_answered() { processor_.answered(std::chrono::steady_clock::now() - asked_); }
  // Since then, but for what it waited for a processor meanwhile: a busy machine is no scenario that hangs.
  std::chrono::nanoseconds waited() const;
  bool has_waited(std::chrono::nanoseconds time) const;
  // Makes it print where it is (SIGUSR1), if it can still hear that.
  void ask_where();

 private:
  void give();
  bool pump(std::chrono::milliseconds wait);
  std::optional<Message> next();
  [[noreturn]] void gone();

  hal::ChildProcess process_;
  OneProcessor processor_;
  std::string in_, out_, printed_;
  std::size_t kept_ = 0, dropped_ = 0;
  bool ended_ = false;
  std::chrono::steady_clock::time_point asked_, delay_read_;
  std::chrono::nanoseconds delayed_{0};  // by then, a second before asked_ at most
};

}  // namespace arkmesh::scenarios::python
