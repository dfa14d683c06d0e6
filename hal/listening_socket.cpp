#include "hal/listening_socket.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace arkmesh::hal {

Handle::~Handle() {
  if (fd_ >= 0) ::close(fd_);
}

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
        fmt::format("'{}' is no address to listen on for {}; give an IP address of this machine, such as 127.0.0.1",
                    address, what));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> keeper(found, &::freeaddrinfo);
  Handle out(::socket(found->ai_family, SOCK_STREAM, 0));
  const int yes = 1;
  ::setsockopt(out.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (!out || ::bind(out.get(), found->ai_addr, found->ai_addrlen) != 0 || ::listen(out.get(), 16) != 0) {
    const int why = errno;
    if (why == EADDRINUSE)
      throw std::runtime_error(fmt::format(
          "TCP port {} of {}, for {}, is in use by another program; stop it (ss -ltnp shows it) or give another port",
          port, address, what));
    if (why == EACCES)
      throw std::runtime_error(
          fmt::format("TCP port {}, for {}, is not allowed to ordinary users; take one above 1023", port, what));
    throw std::runtime_error(
        fmt::format("cannot listen on {} port {} for {}: {}", address, port, what, std::strerror(why)));
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

}  // namespace arkmesh::hal
