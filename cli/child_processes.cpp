#include "cli/child_processes.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <utility>

namespace arkmesh::cli {

ChildProcesses::~ChildProcesses() {
  for (Child& child : children_) {
    if (!child.code) {
      ::kill(child.id, SIGKILL);
      ::waitpid(child.id, nullptr, 0);
    }
    ::close(child.out);
  }
}

std::size_t ChildProcesses::start(std::string name, std::vector<std::string> arguments) {
  std::string program = (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "arkmesh").string();
  std::vector<char*> words{program.data()};
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no more files can be opened");
  std::fflush(nullptr);
  const pid_t parent = ::getpid(), id = ::fork();
  if (id < 0) throw std::runtime_error(fmt::format("no more processes can be started: {}", std::strerror(errno)));
  if (id == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(1);  // it was gone before
    ::dup2(ends[1], STDOUT_FILENO);
    ::dup2(ends[1], STDERR_FILENO);
    ::execv(program.c_str(), words.data());
    fmt::print(stderr, "{} cannot be started: {}\n", program, std::strerror(errno));
    std::fflush(stderr);
    ::_exit(1);
  }
  ::close(ends[1]);
  children_.push_back({.name = std::move(name), .id = id, .out = ends[0], .line = {}, .code = {}});
  return children_.size() - 1;
}

void ChildProcesses::serve(std::chrono::milliseconds wait) {
  std::vector<pollfd> outs;
  for (const Child& child : children_) outs.push_back({child.code ? -1 : child.out, POLLIN, 0});
  ::poll(outs.data(), outs.size(), static_cast<int>(wait.count()));
  for (std::size_t i = 0; i < children_.size(); ++i) {
    Child& child = children_[i];
    if (child.code) continue;
    // Whether it has ended is looked up before what it said last is read.
    int status = 0;
    const bool ended = ::waitpid(child.id, &status, WNOHANG) == child.id;
    if (ended || outs[i].revents != 0) print(child);
    if (ended && !child.line.empty()) fmt::print("{}: {}\n", child.name, std::exchange(child.line, {}));
    if (ended) child.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
}

// What has come so far.
void ChildProcesses::print(Child& child) {
  std::array<char, 4096> some;
  pollfd more{child.out, POLLIN, 0};
  while (::poll(&more, 1, 0) == 1) {
    const ssize_t n = ::read(child.out, some.data(), some.size());
    if (n <= 0) break;
    child.line.append(some.data(), static_cast<std::size_t>(n));
  }
  for (std::size_t end = 0; (end = child.line.find('\n')) != std::string::npos; child.line.erase(0, end + 1))
    fmt::print("{}: {}\n", child.name, child.line.substr(0, end));
  std::fflush(stdout);
}

void ChildProcesses::signal(std::size_t child, int number) {
  if (!children_[child].code) ::kill(children_[child].id, number);
}

}  // namespace arkmesh::cli
