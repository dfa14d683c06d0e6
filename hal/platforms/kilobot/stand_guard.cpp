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
#include <utility>

#include "hal/files/own_files.hpp"
#include "hal/platforms/kilobot/guard_words.hpp"
#include "hal/platforms/kilobot/port_lock.hpp"

extern char** environ;

namespace arkmesh::hal::kilobot {
namespace {

using namespace std::chrono_literals;

constexpr int word_descriptor = 3;  // in the guard
constexpr std::chrono::milliseconds lives_each = 200ms;

}  // namespace

StandGuard::StandGuard(const std::string& port, std::chrono::milliseconds hung_after) {
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
    std::string name = process_name, given = port, descriptor = std::to_string(word_descriptor),
                hung_ms = std::to_string(hung_after.count());
    std::array<char*, 5> arguments{name.data(), given.data(), descriptor.data(), hung_ms.data(), nullptr};
    pid_t process = 0;
    error = ::posix_spawn(&process, program.c_str(), &files, &attributes, arguments.data(), environ);
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
  }
  if (error == 0) return;
  word_ = Handle();
  spdlog::warn("nothing will stop the robots if this program is killed: {} cannot be started ({})", program,
               std::strerror(error));
}

void StandGuard::tell(const State& state) {
  const TimePoint now = machine_time().now();
  const bool is_new = told_ != state;
  if (!word_ || (!is_new && now - lived_ < lives_each)) return;
  const std::array<std::uint8_t, 4> bytes{guard_word::state, static_cast<std::uint8_t>(state.wanted), state.all_stand,
                                          state.ended};
  const std::uint8_t lives = guard_word::lives;
  if (state.said && lock_) std::exchange(lock_, nullptr)->take_over();
  if (!(is_new ? send(bytes.data(), bytes.size()) : send(&lives, 1))) return;
  told_ = state;
  lived_ = now;
}

void StandGuard::has_line(int descriptor) {
  takes_line_ = false;
  if (descriptor < 0 && !has_line_) return;
  has_line_ = descriptor >= 0;
  const std::uint8_t word = has_line_ ? guard_word::line : guard_word::no_line;
  leaves_line_ = send(&word, 1, descriptor) && !has_line_;
}

bool StandGuard::takes_line() {
  hear();
  return takes_line_;
}

bool StandGuard::has_left_line() {
  hear();
  return !leaves_line_ || !word_;
}

void StandGuard::hear() {
  std::uint8_t word = 0;
  ssize_t n = 0;
  while (word_ && (n = ::recv(word_.get(), &word, 1, MSG_DONTWAIT)) == 1) {
    takes_line_ = takes_line_ || (word == guard_word::takes_line && has_line_);
    leaves_line_ = leaves_line_ && word != guard_word::leaves_line;
  }
  if (n == 0 && word_) send(&word, 1);  // to nobody: it is gone
}

// Not sent: the guard does not read, or is gone.
bool StandGuard::send(const void* bytes, std::size_t n, int descriptor) {
  if (!word_) return false;
  if (send_word(word_.get(), bytes, n, descriptor)) return true;
  if (errno != EAGAIN && errno != EWOULDBLOCK) {
    word_ = Handle();
    spdlog::warn("the guard, which stops the robots if this program is killed, has ended");
  }
  return false;
}

}  // namespace arkmesh::hal::kilobot
