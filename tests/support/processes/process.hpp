// A child process of a test: its output goes to a file, it never outlives the test, and waiting has a deadline.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace arkmesh::tests {

class Process {
 public:
  // Starts `program` with `arguments`; stdout and stderr go to `output`.
  Process(const std::string& program, const std::vector<std::string>& arguments, std::filesystem::path output);
  ~Process();  // kills it when it still runs
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number);
  // SIGKILL, and reaps it.
  void kill();
  bool running();
  // Exit code, 128 + signal when it was killed, nothing when it still runs at the deadline.
  std::optional<int> wait(std::chrono::milliseconds deadline);
  std::string output() const;
  pid_t id() const { return pid_; }

 private:
  pid_t pid_ = -1;
  std::optional<int> code_;
  std::filesystem::path output_;
};

// Calls `condition` until it is true or the deadline has passed, with a pause after each call; says which. The last
// call begins after the deadline, however late this process is woken.
template <class Condition>
bool eventually(std::chrono::milliseconds deadline, Condition condition) {
  const auto until = std::chrono::steady_clock::now() + deadline;
  for (;;) {
    const bool last = std::chrono::steady_clock::now() > until;
    if (condition()) return true;
    if (last) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

// A new empty folder below the system's temporary folder, removed with its content at the end unless ARKMESH_KEEP is
// set.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string read_file(const std::filesystem::path& file);

}  // namespace arkmesh::tests
