// The forked process may not use memory of its own, nor anything with a lock: another thread of the program may have
// held it at that moment.
#include "hal/platforms/kilobot/pause_guard.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include "hal/platforms/kilobot/packet.hpp"

namespace arkmesh::hal::kilobot {
namespace {

constexpr int pause_for_ms = 500;  // each time; the controller repeats it 96 times a second
constexpr int line_takes_within_ms = 2000;

// What the guard says. The program may have been killed within a packet: what that leaves on the line can look like a
// packet once, together with the beginning of the next one, and make the controller deaf for 0.1 s. So a stop goes
// first, and the pause is said twice.
struct GuardWords {
  Packet pause = forward_packet(Message{.type = type_wakeup});
  Packet stop = parting_stop(pause, pause);
};

// Ends the process when nobody takes the packet. Nothing follows for so long.
void put(int line, const Packet& packet, int then_ms) {
  for (std::size_t done = 0; done < packet.size();) {
    pollfd takes{line, POLLOUT, 0};
    if (::poll(&takes, 1, line_takes_within_ms) <= 0) ::_exit(1);
    const ssize_t n = ::write(line, packet.data() + done, packet.size() - done);
    if (n < 0 && errno != EAGAIN) ::_exit(1);
    done += static_cast<std::size_t>(std::max<ssize_t>(n, 0));
  }
  ::poll(nullptr, 0, then_ms);
}

[[noreturn]] void stand_guard(int line, int word, const GuardWords& words) {
  ::prctl(PR_SET_NAME, "arkmesh-guard");
  const auto [low, high] = std::minmax({static_cast<unsigned>(line), static_cast<unsigned>(word)});
  if (low > 0) ::close_range(0, low - 1, 0);
  if (high > low + 1) ::close_range(low + 1, high - 1, 0);
  ::close_range(high + 1, ~0u, 0);
  char heard = 0;
  if (::read(word, &heard, 1) == 1) ::_exit(0);
  constexpr int stop_ms = stop_spacing / std::chrono::milliseconds(1);
  put(line, words.stop, stop_ms);
  for (int i = 0; i < 2; ++i) {
    put(line, words.pause, pause_for_ms);
    put(line, words.stop, stop_ms);
  }
  ::_exit(0);
}

class GuardedStream final : public ByteStream {
 public:
  explicit GuardedStream(std::unique_ptr<ByteStream> stream) : stream_(std::move(stream)) { check(); }
  void open() override { stream_->open(); }
  State check() final {
    const State state = stream_->check();
    if (state != State::open)
      guard_.reset();
    else if (!guard_)
      guard_ = std::make_unique<PauseGuard>(stream_->descriptor());
    return state;
  }
  std::size_t write(std::span<const std::uint8_t> bytes) override { return stream_->write(bytes); }
  std::size_t waiting_bytes() override { return stream_->waiting_bytes(); }
  const std::string& trouble() const override { return stream_->trouble(); }
  int descriptor() const override { return stream_->descriptor(); }

 private:
  std::unique_ptr<ByteStream> stream_;
  std::unique_ptr<PauseGuard> guard_;
};

}  // namespace

PauseGuard::PauseGuard(int line) {
  const GuardWords words;
  std::array<int, 2> ends{-1, -1};
  sigset_t all, before;
  ::sigfillset(&all);
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0) {
    const Handle theirs(ends[1]);
    word_ = Handle(ends[0]);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);  // none reaches the new process, at no time
    process_ = ::fork();
    if (process_ == 0) stand_guard(line, theirs.get(), words);
    if (process_ > 0) ::setpgid(process_, process_);  // what kills the program's whole group does not kill this
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
  if (process_ < 0)
    spdlog::warn("no process can be made that pauses the robots should this one be killed: {}", std::strerror(errno));
}

PauseGuard::~PauseGuard() {
  if (process_ < 0) return;
  const char dismissed = 0;
  ::send(word_.get(), &dismissed, 1, MSG_NOSIGNAL);
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

std::unique_ptr<ByteStream> guarded(std::unique_ptr<ByteStream> stream) {
  return std::make_unique<GuardedStream>(std::move(stream));
}

}  // namespace arkmesh::hal::kilobot
