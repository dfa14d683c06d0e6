// The other end of tcp://: takes what is said to an overhead controller.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace arkmesh::tests {

// A TCP port on loopback that takes one connection at a time, as ser2net does.
class Listener {
 public:
  Listener() {
    const int on = 1;
    ::setsockopt(fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    listen_on(0);
  }
  ~Listener() { stop(), ::close(fd_); }
  std::string port() const { return "tcp://127.0.0.1:" + std::to_string(number_); }
  // What has come since the last call; takes a connection if there is none.
  std::vector<std::uint8_t> read() {
    if (client_ < 0) client_ = ::accept4(fd_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    std::vector<std::uint8_t> out(4096);
    const ssize_t got = client_ < 0 ? -1 : ::recv(client_, out.data(), out.size(), 0);
    if (got == 0 && client_ >= 0) hang_up();  // so did the other end
    out.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return out;
  }
  // To whoever is connected; false: nobody is yet.
  bool say(const std::string& text) {
    read();
    return client_ >= 0 && ::send(client_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  void hang_up() {
    if (client_ >= 0) ::close(client_);
    client_ = -1;
  }
  // Nobody listens any more, until listen_again() at the same port.
  void stop() { hang_up(), ::close(fd_), fd_ = -1; }
  void listen_again() {
    fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const int on = 1;
    ::setsockopt(fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    listen_on(number_);
  }

 private:
  void listen_on(std::uint16_t number) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(number);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || ::listen(fd_, 1) != 0)
      throw std::runtime_error("no TCP port to listen on");
    socklen_t length = sizeof address;
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &length);
    number_ = ntohs(address.sin_port);
  }
  int fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0), client_ = -1;
  std::uint16_t number_ = 0;
};

}  // namespace arkmesh::tests
