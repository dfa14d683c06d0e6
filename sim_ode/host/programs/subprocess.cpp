// posix_spawn with one pipe for both outputs, in a process group of its own.
#include "sim_ode/host/programs/subprocess.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>

extern char** environ;

namespace arkmesh::sim_ode {

Finished run_to_end(const std::vector<std::string>& command, std::chrono::milliseconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  Finished out;
  int pipe_ends[2];
  if (pipe2(pipe_ends, O_CLOEXEC) != 0) return out;

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, pipe_ends[1], 1);
  posix_spawn_file_actions_adddup2(&files, pipe_ends[1], 2);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);

  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  pid_t child = -1;
  const int failed = posix_spawnp(&child, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  close(pipe_ends[1]);

  if (!failed) {
    // a signal from the terminal that ends us does not reach it: then it ends by itself
    const auto seconds = static_cast<rlim_t>(std::chrono::ceil<std::chrono::seconds>(limit).count()) + 1;
    const rlimit processor_time{seconds, seconds};
    prlimit(child, RLIMIT_CPU, &processor_time, nullptr);
  }

  // read to the end, also what is not kept, so that the program can finish
  char part[4096];
  constexpr std::size_t most = 64 << 10;
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    pollfd ready{pipe_ends[0], POLLIN, 0};
    const int come = poll(&ready, 1, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 1'000'000)));
    if (come < 0 && errno == EINTR) continue;
    if (come == 0) {
      out.too_long = true;
      if (!failed) kill(-child, SIGKILL);
      break;
    }
    const ssize_t n = read(pipe_ends[0], part, sizeof part);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    if (out.output.size() < most) out.output.append(part, static_cast<std::size_t>(n));
  }
  close(pipe_ends[0]);
  if (failed) return out;

  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status)) out.status = WEXITSTATUS(status);
  return out;
}

std::filesystem::path script_of_arkmesh(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path installed =
      fs::read_symlink("/proc/self/exe", ignored).parent_path().parent_path() / "share" / "arkmesh" / name;
  return fs::exists(installed, ignored) ? installed : fs::path(ARKMESH_SOURCE_DIR) / "scripts" / name;
}

}  // namespace arkmesh::sim_ode
