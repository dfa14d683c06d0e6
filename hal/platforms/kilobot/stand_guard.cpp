#include "hal/platforms/kilobot/stand_guard.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>

#include "hal/own_files.hpp"

extern char** environ;

namespace arkmesh::hal::kilobot {
namespace {

constexpr int word_descriptor = 3;  // in the guard

}  // namespace

StandGuard::StandGuard(const std::string& port) {
  std::array<int, 2> ends{-1, -1};
  const std::string program = (program_folder() / process_name).string();
  int error = ::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) == 0 ? 0 : errno;
  if (error == 0) {
    word_ = Handle(ends[0]);
    const Handle theirs(ends[1]);
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawnattr_init(&attributes);
    // What kills this program's group or closes its terminal does not reach the guard, and it keeps nobody's output
    // open.
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
    for (const int standard : {0, 1, 2}) ::posix_spawn_file_actions_addopen(&files, standard, "/dev/null", O_RDWR, 0);
    ::posix_spawn_file_actions_adddup2(&files, theirs.get(), word_descriptor);
    ::posix_spawn_file_actions_addclosefrom_np(&files, word_descriptor + 1);
    ::posix_spawn_file_actions_addchdir_np(&files, "/");
    std::string name = process_name, given = port, descriptor = std::to_string(word_descriptor);
    std::array<char*, 4> arguments{name.data(), given.data(), descriptor.data(), nullptr};
    pid_t process = 0;
    error = ::posix_spawn(&process, program.c_str(), &files, &attributes, arguments.data(), environ);
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
  }
  if (error == 0) return;
  word_ = Handle();
  spdlog::warn("nobody will tell the robots to stand should this program be killed: {} cannot be started ({})", program,
               std::strerror(error));
}

void StandGuard::tell(const State& state) {
  if (!word_ || told_ == state) return;
  const std::array<std::uint8_t, 3> bytes{static_cast<std::uint8_t>(state.wanted), state.all_stand, state.ended};
  if (::send(word_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT) == std::ssize(bytes)) {
    told_ = state;
  } else if (errno != EAGAIN && errno != EWOULDBLOCK) {
    word_ = Handle();
    spdlog::warn("the process that tells the robots to stand should this program be killed is gone itself");
  }
}

}  // namespace arkmesh::hal::kilobot
