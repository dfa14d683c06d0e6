#include "sim_ode/room/byte_ports.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <utility>

namespace arkmesh::sim_ode::room {
namespace {

constexpr std::size_t most_clients = 8, most_line_bytes = 1024, most_answer_bytes = 1 << 16;

void no_waiting(int fd) {
  ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) | O_NONBLOCK);
  ::fcntl(fd, F_SETFD, FD_CLOEXEC);
}

Handle listen_on(const std::string& address, std::uint16_t port, const std::string& what) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  const std::string numeric = address == "localhost" ? "127.0.0.1" : address;
  if (::getaddrinfo(numeric.c_str(), std::to_string(port).c_str(), &hints, &found) != 0)
    throw std::runtime_error(
        fmt::format("room.listen = \"{}\" is no address; give an IP address of this machine, such as 127.0.0.1", address));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> keeper(found, &::freeaddrinfo);
  Handle out(::socket(found->ai_family, SOCK_STREAM, 0));
  const int yes = 1;
  ::setsockopt(out.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (!out || ::bind(out.get(), found->ai_addr, found->ai_addrlen) != 0 || ::listen(out.get(), 4) != 0) {
    const int why = errno;
    if (why == EADDRINUSE)
      throw std::runtime_error(
          fmt::format("TCP port {} of {}, for {}, is in use by another program; stop it (ss -ltnp shows it) or give another port", port,
                      address, what));
    throw std::runtime_error(fmt::format("cannot listen on {} port {} for {}: {}", address, port, what, std::strerror(why)));
  }
  no_waiting(out.get());
  return out;
}

std::uint16_t port_of(int fd) {
  sockaddr_storage name{};
  socklen_t size = sizeof name;
  if (::getsockname(fd, reinterpret_cast<sockaddr*>(&name), &size) != 0) return 0;
  return ntohs(name.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(name).sin6_port
                                          : reinterpret_cast<const sockaddr_in&>(name).sin_port);
}

bool would_wait() {
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

}  // namespace

Handle::Handle(Handle&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
Handle& Handle::operator=(Handle&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}
Handle::~Handle() {
  if (fd_ >= 0) ::close(fd_);
}

PseudoTerminal::PseudoTerminal(const std::string& link) : master_(::posix_openpt(O_RDWR | O_NOCTTY)), link_(link) {
  std::array<char, 256> name{};
  if (!master_ || ::grantpt(master_.get()) != 0 || ::unlockpt(master_.get()) != 0 ||
      ::ptsname_r(master_.get(), name.data(), name.size()) != 0)
    throw std::runtime_error(fmt::format("cannot make a pseudo-terminal for the overhead controller: {}", std::strerror(errno)));
  path_ = name.data();
  slave_ = Handle(::open(path_.c_str(), O_RDWR | O_NOCTTY));
  termios line{};
  if (!slave_ || ::tcgetattr(slave_.get(), &line) != 0)
    throw std::runtime_error(fmt::format("cannot open the pseudo-terminal {}: {}", path_, std::strerror(errno)));
  ::cfmakeraw(&line);
  ::cfsetspeed(&line, B38400);
  ::tcsetattr(slave_.get(), TCSANOW, &line);
  no_waiting(master_.get());
  if (link_.empty()) return;
  std::error_code error;
  const auto status = std::filesystem::symlink_status(link_, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_symlink(status)) {
    const std::string there = std::exchange(link_, {});
    throw std::runtime_error(fmt::format("room.ohc_link = \"{}\" is there and no symbolic link; give another name", there));
  }
  std::filesystem::remove(link_, error);
  std::filesystem::create_symlink(path_, link_, error);
  if (error)
    throw std::runtime_error(fmt::format("cannot make the link room.ohc_link = \"{}\": {}", std::exchange(link_, {}), error.message()));
}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  if (!link_.empty() && std::filesystem::read_symlink(link_, ignored) == path_) std::filesystem::remove(link_, ignored);
}

std::vector<std::uint8_t> PseudoTerminal::read(std::size_t most) {
  std::vector<std::uint8_t> out(most);
  const ssize_t n = most == 0 ? 0 : ::read(master_.get(), out.data(), most);
  out.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  return out;
}

TcpPort::TcpPort(const std::string& address, std::uint16_t port, const std::string& what) : listener_(listen_on(address, port, what)) {}
std::uint16_t TcpPort::port() const {
  return port_of(listener_.get());
}

void TcpPort::accept() {
  for (std::size_t k = 0; k < most_clients; ++k) {
    Handle client(::accept(listener_.get(), nullptr, nullptr));
    if (!client) return;
    no_waiting(client.get());
    if (!client_) client_ = std::move(client);
  }
}

std::vector<std::uint8_t> TcpPort::read(std::size_t most) {
  std::vector<std::uint8_t> out(most);
  if (!client_ || most == 0) return {};
  const ssize_t n = ::recv(client_.get(), out.data(), most, 0);
  if (n == 0 || (n < 0 && !would_wait())) send_away();
  out.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  return out;
}

LinePort::LinePort(const std::string& address, std::uint16_t port, const std::string& what) : listener_(listen_on(address, port, what)) {}
std::uint16_t LinePort::port() const {
  return port_of(listener_.get());
}

void LinePort::serve(const std::function<std::string(std::string_view)>& answer) {
  for (std::size_t k = 0; k < most_clients; ++k) {
    Handle client(::accept(listener_.get(), nullptr, nullptr));
    if (!client) break;
    no_waiting(client.get());
    if (clients_.size() < most_clients) clients_.push_back({.handle = std::move(client)});
  }
  std::erase_if(clients_, [&answer](Client& client) { return !serve(client, answer); });
}

bool LinePort::serve(Client& client, const std::function<std::string(std::string_view)>& answer) {
  std::array<char, 1024> some;
  bool ended = false;
  const ssize_t n = ::recv(client.handle.get(), some.data(), some.size(), 0);
  if (n == 0)
    ended = true;
  else if (n < 0 && !would_wait())
    return false;
  if (n > 0) client.in.append(some.data(), static_cast<std::size_t>(n));
  for (std::size_t end; (end = client.in.find('\n')) != std::string::npos; client.in.erase(0, end + 1))
    client.out += answer(std::string_view(client.in).substr(0, end)) + "\n";
  if (client.in.size() > most_line_bytes || client.out.size() > most_answer_bytes) return false;
  if (!client.out.empty()) {
    const ssize_t sent = ::send(client.handle.get(), client.out.data(), client.out.size(), MSG_NOSIGNAL);
    if (sent < 0 && !would_wait()) return false;
    if (sent > 0) client.out.erase(0, static_cast<std::size_t>(sent));
  }
  return !ended;
}

}  // namespace arkmesh::sim_ode::room
