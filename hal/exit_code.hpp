// The exit codes of all commands: one table, for programs, scripts, and docs/formats.md.
#pragma once

#include <stdexcept>
#include <string>

namespace arkmesh::hal {

struct Exit {
  static constexpr int done = 0, failed = 1, refused = 2, stopped = 3, not_standing = 4, port_taken = 5;
};

struct ExitCodeRow {
  int code;
  const char* meaning;
};
inline constexpr ExitCodeRow exit_codes[] = {
    {Exit::done, "done"},
    {Exit::failed, "failed"},
    {Exit::refused, "wrong command line or configuration"},
    {Exit::stopped, "the operator stopped the lab or run"},
    {Exit::not_standing, "robots told to stop were not seen standing"},
    {Exit::port_taken, "another program has the overhead controller's port"},
};

// Ends the command with this code.
class ExitError : public std::runtime_error {
 public:
  ExitError(int code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  int code() const { return code_; }

 private:
  int code_;
};

}  // namespace arkmesh::hal
