#include "emulator/byte_ports.hpp"

#include <fcntl.h>
#include <fmt/format.h>
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

namespace arkmesh::emulator {
namespace {

constexpr std::size_t max_clients = 8, max_line_bytes = 1024, max_answer_bytes = 1 << 16;

bool would_wait() {
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

}  // namespace

PseudoTerminal::PseudoTerminal(const std::string& link) : master_(::posix_openpt(O_RDWR | O_NOCTTY)), link_(link) {
  std::array<char, 256> name{};
  if (!master_ || ::grantpt(master_.get()) != 0 || ::unlockpt(master_.get()) != 0 ||
      ::ptsname_r(master_.get(), name.data(), name.size()) != 0)
    throw std::runtime_error(
        fmt::format("cannot make a pseudo-terminal for the overhead controller: {}", std::strerror(errno)));
  path_ = name.data();
  slave_ = Handle(::open(path_.c_str(), O_RDWR | O_NOCTTY));
  termios line{};
  if (!slave_ || ::tcgetattr(slave_.get(), &line) != 0)
    throw std::runtime_error(fmt::format("cannot open the pseudo-terminal {}: {}", path_, std::strerror(errno)));
  ::cfmakeraw(&line);
  ::cfsetspeed(&line, B38400);
  ::tcsetattr(slave_.get(), TCSANOW, &line);
  hal::no_waiting(master_.get());
  if (link_.empty()) return;
  std::error_code error;
  const auto status = std::filesystem::symlink_status(link_, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_symlink(status)) {
    const std::string there = std::exchange(link_, {});
    throw std::runtime_error(
        fmt::format("emulator.ohc_link = \"{}\" is there and no symbolic link; give another name", there));
  }
  std::filesystem::remove(link_, error);
  std::filesystem::create_symlink(path_, link_, error);
  if (error)
    throw std::runtime_error(
        fmt::format("cannot make the link emulator.ohc_link = \"{}\": {}", std::exchange(link_, {}), error.message()));
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

TcpPort::TcpPort(const std::string& address, std::uint16_t port, const std::string& what)
    : listener_(hal::listen_on(address, port, what)) {}
std::uint16_t TcpPort::port() const {
  return hal::port_of(listener_.get());
}

void TcpPort::accept() {
  for (std::size_t k = 0; k < max_clients; ++k) {
    Handle client(::accept(listener_.get(), nullptr, nullptr));
    if (!client) return;
    hal::no_waiting(client.get());
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

LinePort::LinePort(const std::string& address, std::uint16_t port, const std::string& what)
    : listener_(hal::listen_on(address, port, what)) {}
std::uint16_t LinePort::port() const {
  return hal::port_of(listener_.get());
}

void LinePort::serve(const std::function<std::string(std::string_view)>& answer) {
  for (std::size_t k = 0; k < max_clients; ++k) {
    Handle client(::accept(listener_.get(), nullptr, nullptr));
    if (!client) break;
    hal::no_waiting(client.get());
    if (clients_.size() < max_clients) clients_.push_back({.handle = std::move(client)});
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
  if (client.in.size() > max_line_bytes || client.out.size() > max_answer_bytes) return false;
  if (!client.out.empty()) {
    const ssize_t sent = ::send(client.handle.get(), client.out.data(), client.out.size(), MSG_NOSIGNAL);
    if (sent < 0 && !would_wait()) return false;
    if (sent > 0) client.out.erase(0, static_cast<std::size_t>(sent));
  }
  return !ended;
}

}  // namespace arkmesh::emulator
