#include "tests/support/network/two_hosts.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace arkmesh::tests {

namespace {

hal::Handle own_namespace() {
  return hal::Handle(::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC));
}

sockaddr_in ip_address(const std::string& ip, int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  ::inet_pton(AF_INET, ip.c_str(), &address.sin_addr);
  return address;
}

}  // namespace

TwoHosts::TwoHosts() {
  const hal::Handle home = own_namespace();
  if (::unshare(CLONE_NEWNET) == 0) {
    lab_ = own_namespace();
    if (::unshare(CLONE_NEWNET) == 0) stranger_ = own_namespace();
  }
  const int error = errno;
  if (::setns(home.get(), CLONE_NEWNET) != 0) throw std::runtime_error("cannot leave a network namespace");
  if (!stranger_)
    throw std::runtime_error(fmt::format("this user may not make network namespaces ({})", std::strerror(error)));
  const std::string other = fmt::format("/proc/{}/fd/{}", ::getpid(), stranger_.get());
  if (!run_in(lab_.get(), "ip link set lo up && ip link add lab0 type veth peer name str0 netns " + other +
                              " && ip addr add 10.9.0.1/24 dev lab0 && ip link set lab0 up"
                              " && ip route add 224.0.0.0/4 dev lab0") ||
      !run_in(stranger_.get(),
              "ip link set lo up && ip addr add 10.9.0.2/24 dev str0"
              " && ip addr add 10.9.0.3/24 dev str0 && ip link set str0 up"
              " && ip route add 224.0.0.0/4 dev str0"))
    throw std::runtime_error("there are no virtual Ethernet devices here");
}

Inside::Inside(int host) : before_(own_namespace()) {
  if (::setns(host, CLONE_NEWNET) != 0) throw std::runtime_error("cannot enter a network namespace");
}

Inside::~Inside() {
  if (::setns(before_.get(), CLONE_NEWNET) != 0) std::abort();
}

UdpSender::UdpSender(int host, const std::string& from) {
  const Inside inside(host);
  socket_ = hal::Handle(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const auto own = ip_address(from, 0);
  if (::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0 ||
      ::setsockopt(socket_.get(), IPPROTO_IP, IP_MULTICAST_IF, &own.sin_addr, sizeof own.sin_addr) != 0)
    throw std::runtime_error("cannot send from " + from);
}

void UdpSender::send(std::span<const std::byte> datagram, const std::string& to, int port) const {
  const auto there = ip_address(to, port);
  // What the kernel has no room for is not sent.
  (void)::sendto(socket_.get(), datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&there),
                 sizeof there);
}

bool run_in(int host, const std::string& command) {
  const Inside inside(host);
  return std::system(command.c_str()) == 0;
}

}  // namespace arkmesh::tests
