// TCP ports that a program of ours listens on itself, without blocking, and file descriptors that close themselves.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace arkmesh::hal {

// A file descriptor that closes itself.
class Handle {
 public:
  explicit Handle(int fd = -1) : fd_(fd) {}
  Handle(Handle&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Handle();
  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }

 private:
  int fd_;
};

// Reads and writes return at once; programs that we start do not inherit it.
void no_waiting(int fd);
// Listens on `address`, an IP address of this machine or "localhost"; port 0 takes any free one. Throws
// std::runtime_error with one sentence; `what` says in it what the port is for ("pictures").
Handle listen_on(const std::string& address, std::uint16_t port, const std::string& what);
// The port that a listening socket has; 0 when it has none.
std::uint16_t port_of(int fd);

}  // namespace arkmesh::hal
