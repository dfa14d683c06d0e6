#include "hal/platforms/kilobot/descriptor_stream.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

namespace arkmesh::hal::kilobot {
namespace {

constexpr std::chrono::seconds connects_within{1};  // another attempt may find the path that is back

bool is_for_later(int code) {
  return code == EAGAIN || code == EINTR;
}

}  // namespace

Line find_line(const std::string& port) {
  constexpr std::string_view tcp = "tcp://";
  if (port.starts_with(tcp)) return tcp_line(port.substr(tcp.size()));
  if (port.empty())
    throw PortError(
        "the name of the overhead controller's port is empty; write a device such as /dev/ttyUSB0, or tcp://host:port");
  if (port.find("://") != std::string::npos)
    throw PortError(fmt::format("{}: write a device such as /dev/ttyUSB0, or tcp://host:port", port));
  return serial_line(port.front() == '/' ? port : "/dev/" + port);
}

void DescriptorStream::open() {
  if (descriptor_ || (line_.guard && !line_.guard->has_left_line())) return;
  try {
    began_ = machine_time().now();
    descriptor_ = line_.open();
    if (!line_.connects) opened();
  } catch (const PortError& why) {
    error_ = why.what();
  }
}

ByteStream::State DescriptorStream::check() {
  heard_bytes_ = 0;
  if (!descriptor_) return State::closed;
  if (line_.guard && line_.guard->takes_line()) return lose(ETIME);
  pollfd state{descriptor_.get(), static_cast<short>(open_ ? POLLIN : POLLOUT), 0};
  const bool ready = ::poll(&state, 1, 0) > 0;
  if (open_) {
    if (!ready) return State::open;
    const ssize_t read = ::read(descriptor_.get(), heard_.data(), heard_.size());
    heard_bytes_ = static_cast<std::size_t>(std::max<ssize_t>(read, 0));
    return read > 0 || (read < 0 && is_for_later(errno)) ? State::open : lose(read < 0 ? errno : 0);
  }
  int code = ETIMEDOUT;
  socklen_t length = sizeof code;
  if (ready)
    ::getsockopt(descriptor_.get(), SOL_SOCKET, SO_ERROR, &code, &length);
  else if (machine_time().now() - began_ <= connects_within)
    return State::opening;
  if (code != 0) return lose(code);
  opened();
  return State::open;
}

void DescriptorStream::opened() {
  open_ = true;
  error_.clear();
  if (line_.guard) line_.guard->has_line(descriptor_.get());
}

std::size_t DescriptorStream::write(std::span<const std::uint8_t> bytes) {
  if (!open_ || bytes.empty() || (line_.guard && line_.guard->takes_line())) return 0;
  ssize_t written = ::send(descriptor_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (written < 0 && errno == ENOTSOCK) written = ::write(descriptor_.get(), bytes.data(), bytes.size());
  if (written >= 0) return static_cast<std::size_t>(written);
  if (!is_for_later(errno)) lose(errno);
  return 0;
}

std::size_t DescriptorStream::waiting_bytes() {
  int waiting = 0;  // a socket takes the same request
  return open_ && ::ioctl(descriptor_.get(), TIOCOUTQ, &waiting) == 0 && waiting > 0 ? static_cast<std::size_t>(waiting)
                                                                                     : 0;
}

bool DescriptorStream::reset() {
  if (!open_ || !line_.connects) return false;
  const sockaddr nobody{.sa_family = AF_UNSPEC, .sa_data = {}};
  ::connect(descriptor_.get(), &nobody, sizeof nobody);
  error_ =
      "most robots walk or turn although they were told to stop, so this program resets the connection to discard what "
      "waits "
      "in it";
  close();
  return true;
}

ByteStream::State DescriptorStream::lose(int code) {
  error_ = code == ETIME ? "this program was suspended, so its guard stopped the robots" : line_.why_lost(open_, code);
  close();
  return State::closed;
}

// The guard's copy of the descriptor ends with it: what holds a device or a connection is not the descriptor.
void DescriptorStream::close() {
  if (!descriptor_) return;
  ::shutdown(descriptor_.get(), SHUT_RDWR);
  ::ioctl(descriptor_.get(), TIOCNXCL);
  ::flock(descriptor_.get(), LOCK_UN);
  if (line_.guard) line_.guard->has_line(-1);
  descriptor_ = Handle();
  open_ = false;
}

}  // namespace arkmesh::hal::kilobot
