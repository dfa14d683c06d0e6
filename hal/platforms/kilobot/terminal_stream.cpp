// Set as a serial line is, raw and at the controller's speed, although nothing has that speed here.
#include "hal/platforms/kilobot/terminal_stream.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace arkmesh::hal::kilobot {

std::string why_in_use(const std::string& path) {
  return fmt::format(
      "{} is in use by another program, perhaps a lab: only one can drive a controller, so end that one first; "
      "`fuser -v {}` names it",
      path, path);
}

void TerminalStream::open() {
  if (terminal_) return;
  terminal_ = Handle(::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!terminal_ && errno != EBUSY) return lose(fmt::format("{} cannot be opened: {}", path_, std::strerror(errno)));
  // For us alone by a lock, which ends with us. TIOCEXCL stays on a pseudo-terminal while its other end is open, so
  // that nobody but root could open it again.
  if (!terminal_ || ::flock(terminal_.get(), LOCK_EX | LOCK_NB) != 0) return lose(why_in_use(path_));
  termios line{};
  if (::tcgetattr(terminal_.get(), &line) != 0)
    return lose(fmt::format("{} is no terminal: {}", path_, std::strerror(errno)));
  ::cfmakeraw(&line);
  line.c_cflag = (line.c_cflag & ~static_cast<tcflag_t>(CSTOPB | CRTSCTS)) | CLOCAL | CREAD;
  ::cfsetspeed(&line, B38400);
  if (::tcsetattr(terminal_.get(), TCSANOW, &line) != 0)
    return lose(fmt::format("{} does not take 38400 baud, 8N1: {}", path_, std::strerror(errno)));
  ::tcflush(terminal_.get(), TCIOFLUSH);
  trouble_.clear();
}

ByteStream::State TerminalStream::check() {
  heard_bytes_ = 0;
  if (!terminal_) return State::closed;
  pollfd state{terminal_.get(), POLLIN, 0};
  if (::poll(&state, 1, 0) <= 0) return State::open;
  bool is_gone = (state.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
  if (!is_gone) {
    const ssize_t read = ::read(terminal_.get(), heard_.data(), heard_.size());
    heard_bytes_ = static_cast<std::size_t>(std::max<ssize_t>(read, 0));
    is_gone = read <= 0 && errno != EAGAIN && errno != EINTR;
  }
  if (!is_gone) return State::open;
  lose(fmt::format("{} was unplugged", path_));
  return State::closed;
}

std::size_t TerminalStream::write(std::span<const std::uint8_t> bytes) {
  if (!terminal_ || bytes.empty()) return 0;
  const ssize_t written = ::write(terminal_.get(), bytes.data(), bytes.size());
  if (written >= 0) return static_cast<std::size_t>(written);
  if (errno != EAGAIN && errno != EINTR) lose(fmt::format("{} was unplugged ({})", path_, std::strerror(errno)));
  return 0;
}

std::size_t TerminalStream::waiting_bytes() {
  int waiting = 0;
  return terminal_ && ::ioctl(terminal_.get(), TIOCOUTQ, &waiting) == 0 && waiting > 0
             ? static_cast<std::size_t>(waiting)
             : 0;
}

void TerminalStream::lose(std::string why) {
  terminal_ = Handle();
  trouble_ = std::move(why);
}

}  // namespace arkmesh::hal::kilobot
