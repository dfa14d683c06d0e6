// Commands of arkmesh as child processes: what they say is printed line by line behind a name, and none outlives this
// process.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace arkmesh::cli {

class ChildProcesses {
 public:
  ChildProcesses() = default;
  ~ChildProcesses();  // kills what still runs
  ChildProcesses(const ChildProcesses&) = delete;
  ChildProcesses& operator=(const ChildProcesses&) = delete;

  struct Child {
    std::string name;  // stands before its lines
    pid_t id = -1;
    int out = -1;             // what it says
    std::string line;         // what it has begun to say
    std::optional<int> code;  // 128 + signal when it was killed
  };
  // Starts `arkmesh ARGUMENTS`, of the folder of this program; Ctrl-C does not reach it. Returns its number. Throws
  // std::runtime_error.
  std::size_t start(std::string name, std::vector<std::string> arguments);
  // Prints what they say for up to `wait`, and takes notice of those that have ended.
  void serve(std::chrono::milliseconds wait);
  void signal(std::size_t child, int number);
  const Child& operator[](std::size_t child) const { return children_[child]; }
  std::size_t size() const { return children_.size(); }

 private:
  void print(Child& child);

  std::vector<Child> children_;
};

}  // namespace arkmesh::cli
