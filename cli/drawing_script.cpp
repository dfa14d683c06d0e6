#include "cli/drawing_script.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <stdexcept>

#include "sim_ode/host/programs/subprocess.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

// What scripts look for beside a program that was built, and not installed: the message types for Python.
void tell_types() {
  std::error_code error;
  const fs::path types = fs::read_symlink("/proc/self/exe", error).parent_path() / "lcmtypes" / "python";
  if (fs::is_directory(types, error)) ::setenv("ARKMESH_LCM_TYPES", types.c_str(), 0);
}

}  // namespace

std::string watch_drawing_script(const std::string& name, const std::vector<std::string>& arguments) {
  tell_types();
  std::vector<std::string> words = {sim_ode::script_of_arkmesh(name).string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no more files can be opened");
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    ::dup2(ends[1], STDOUT_FILENO);
    ::execv(argv.front(), argv.data());
    ::_exit(127);
  }
  ::close(ends[1]);
  std::string said;
  char some[4096];
  for (ssize_t n = 0; (n = ::read(ends[0], some, sizeof some)) > 0;) said.append(some, static_cast<std::size_t>(n));
  ::close(ends[0]);
  int status = -1;
  if (child > 0) ::waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) == 127)
    throw std::runtime_error(fmt::format("{} did not run to its end; it needs /usr/bin/python3", words.front()));
  if (WEXITSTATUS(status) != 0) throw std::runtime_error(fmt::format("{} wrote nothing", name));
  while (said.ends_with('\n')) said.pop_back();
  return said;
}

std::string run_drawing_script(const std::string& name, const std::vector<std::string>& arguments) {
  tell_types();
  std::vector<std::string> command = {sim_ode::script_of_arkmesh(name).string()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const sim_ode::Finished done = sim_ode::run_to_end(command, std::chrono::minutes(30));
  std::string last = done.output;
  while (last.ends_with('\n')) last.pop_back();
  if (const auto line = last.rfind('\n'); line != std::string::npos) last.erase(0, line + 1);
  if (done.too_long) throw std::runtime_error(fmt::format("{} took longer than half an hour", command.front()));
  if (done.status != 0)
    throw std::runtime_error(
        last.empty() ? fmt::format("{} cannot be started; it needs /usr/bin/python3", command.front()) : last);
  return last;
}

}  // namespace arkmesh::cli
