// Plain non-blocking sockets: one connection, no protocol, nothing to parse.
#include "hal/platforms/kilobot/tcp_stream.hpp"

#include <fmt/format.h>
#include <linux/sockios.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

namespace arkmesh::hal::kilobot {
namespace {

constexpr std::chrono::seconds connects_within{1};  // another attempt may find the path that is back
constexpr unsigned gone_after_ms = 5000;            // bytes unconfirmed for so long: the other machine is gone

void set(int fd, int level, int option, int value) {
  ::setsockopt(fd, level, option, &value, sizeof value);
}

}  // namespace

TcpStream::TcpStream(const std::string& where) : name_("tcp://" + where) {
  const auto refuse = [&](std::string_view why) { throw PortError(fmt::format("{}: {}", name_, why)); };
  const std::size_t colon = where.rfind(':');
  if (colon == std::string::npos || colon == 0) refuse("write tcp://host:port, such as tcp://192.168.1.20:3001");
  std::string host = where.substr(0, colon);
  const std::string port = where.substr(colon + 1);
  if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  const bool digits =
      !port.empty() && port.size() <= 5 && std::ranges::all_of(port, [](char c) { return c >= '0' && c <= '9'; });
  if (!digits || std::stoi(port) < 1 || std::stoi(port) > 65535) refuse("the port must be a number from 1 to 65535");

  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int code = ::getaddrinfo(host.c_str(), port.c_str(), &hints, &found); code != 0)
    refuse(fmt::format("the host {} is not known: {}", host, ::gai_strerror(code)));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owned(found, &::freeaddrinfo);
  for (const addrinfo* at = found; at; at = at->ai_next) {
    Address address{};
    if (at->ai_addrlen > sizeof address.bytes) continue;
    std::memcpy(&address.bytes, at->ai_addr, at->ai_addrlen);
    address.length = at->ai_addrlen;
    addresses_.push_back(address);
  }
  if (addresses_.empty()) refuse(fmt::format("the host {} has no address", host));
}

void TcpStream::open() {
  if (fd_ >= 0) return;
  const Address& address = addresses_[next_];
  next_ = (next_ + 1) % addresses_.size();
  began_ = machine_time().now();
  fd_ = ::socket(address.bytes.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd_ < 0) return fail("no socket for it", errno);
  set(fd_, IPPROTO_TCP, TCP_NODELAY, 1);
  // a cut cable is noticed in seconds: by unconfirmed bytes, and by probes when nothing is said
  set(fd_, IPPROTO_TCP, TCP_USER_TIMEOUT, gone_after_ms);
  set(fd_, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(fd_, IPPROTO_TCP, TCP_KEEPIDLE, 2);
  set(fd_, IPPROTO_TCP, TCP_KEEPINTVL, 1);
  set(fd_, IPPROTO_TCP, TCP_KEEPCNT, 3);
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address.bytes), address.length) != 0 && errno != EINPROGRESS)
    fail("no connection", errno);
}

ByteStream::State TcpStream::check() {
  heard_bytes_ = 0;
  if (fd_ < 0) return State::closed;
  pollfd state{fd_, static_cast<short>(connected_ ? POLLIN : POLLOUT), 0};
  if (::poll(&state, 1, 0) <= 0) {
    if (connected_) return State::open;
    if (machine_time().now() - began_ <= connects_within) return State::opening;
    fail("no connection", ETIMEDOUT);
    return State::closed;
  }
  if (!connected_) {
    int code = 0;
    socklen_t length = sizeof code;
    ::getsockopt(fd_, SOL_SOCKET, SO_ERROR, &code, &length);
    if (code != 0) {
      fail("no connection", code);
      return State::closed;
    }
    connected_ = true;
    trouble_.clear();
    return State::open;
  }
  const ssize_t read = ::recv(fd_, heard_.data(), heard_.size(), 0);
  heard_bytes_ = static_cast<std::size_t>(std::max<ssize_t>(read, 0));
  if (read > 0 || (read < 0 && (errno == EAGAIN || errno == EINTR))) return State::open;
  fail("the connection ended", read < 0 ? errno : 0);
  return State::closed;
}

std::size_t TcpStream::write(std::span<const std::uint8_t> bytes) {
  if (!connected_ || bytes.empty()) return 0;
  const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (sent >= 0) return static_cast<std::size_t>(sent);
  if (errno != EAGAIN && errno != EINTR) fail("the connection ended", errno);
  return 0;
}

std::size_t TcpStream::waiting_bytes() {
  int waiting = 0;
  return connected_ && ::ioctl(fd_, SIOCOUTQ, &waiting) == 0 && waiting > 0 ? static_cast<std::size_t>(waiting) : 0;
}

void TcpStream::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  connected_ = false;
}

void TcpStream::fail(const std::string& what, int code) {
  close();
  trouble_ =
      code == 0 ? fmt::format("{}: {}", name_, what) : fmt::format("{}: {}: {}", name_, what, std::strerror(code));
  if (code == ECONNREFUSED) trouble_ += "; nobody listens there: is ser2net running, and is this its port?";
}

}  // namespace arkmesh::hal::kilobot
