// Plain non-blocking sockets: one connection, no protocol, nothing to parse. For example to ser2net's raw mode.
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <vector>

#include "hal/platforms/kilobot/descriptor_stream.hpp"

namespace arkmesh::hal::kilobot {
namespace {

constexpr int gone_after_ms = 5000;  // bytes unconfirmed for so long: the other machine is gone
constexpr int long_gone_after_ms = 20'000, repeats_each_ms = 1000;
constexpr int rto_max_option = 44;  // TCP_RTO_MAX_MS, since Linux 6.15

struct Address {
  sockaddr_storage bytes;
  socklen_t length;
};

// Throws PortError, which begins with `name`.
std::vector<Address> addresses_of(const std::string& where, const std::string& name) {
  const auto refuse = [&](std::string_view why) { throw PortError(fmt::format("{}: {}", name, why)); };
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
  std::vector<Address> out;
  for (const addrinfo* at = found; at; at = at->ai_next) {
    Address address{};
    if (at->ai_addrlen > sizeof address.bytes) continue;
    std::memcpy(&address.bytes, at->ai_addr, at->ai_addrlen);
    address.length = at->ai_addrlen;
    out.push_back(address);
  }
  if (out.empty()) refuse(fmt::format("the host {} has no address", host));
  return out;
}

std::string why_lost(const std::string& name, const std::string& hint, bool was_open, int code) {
  std::string why = fmt::format("{}: {}", name, was_open ? "the connection ended" : "no connection");
  if (code != 0) why += fmt::format(": {}", std::strerror(code));
  if (code == ECONNREFUSED) why += "; nobody listens there: " + hint;
  return why;
}

Handle connect(const Address& address) {
  Handle out(::socket(address.bytes.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const auto set = [&out](int level, int option, int value) {
    return ::setsockopt(out.get(), level, option, &value, sizeof value) == 0;
  };
  if (!out) return out;
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  // a cut cable is noticed in seconds: by unconfirmed bytes, and by probes when nothing is said
  // a path that is back is used within a second where the system can repeat so often; else another connection finds it
  const bool repeats = set(IPPROTO_TCP, rto_max_option, repeats_each_ms);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, repeats ? long_gone_after_ms : gone_after_ms);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 2);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 1);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
  const bool begun = ::connect(out.get(), reinterpret_cast<const sockaddr*>(&address.bytes), address.length) == 0 ||
                     errno == EINPROGRESS;
  return begun ? std::move(out) : Handle();
}

}  // namespace

Line tcp_line(const std::string& where, const std::string& hint) {
  const std::string name = "tcp://" + where;
  const auto why = [name, hint](bool was_open, int code) {
    return arkmesh::hal::kilobot::why_lost(name, hint, was_open, code);
  };
  const auto open = [why, addresses = addresses_of(where, name), next = std::size_t{0}]() mutable {
    Handle out = connect(addresses[next++ % addresses.size()]);
    if (!out) throw PortError(why(false, errno));
    return out;
  };
  return {.open = open, .why_lost = why, .connects = true};
}

}  // namespace arkmesh::hal::kilobot
