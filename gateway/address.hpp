// Where gateways listen and connect: on this machine without encryption, on any machine over TLS.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstdint>
#include <string>
#include <string_view>

namespace arkmesh::gateway {

inline constexpr std::string_view tls_scheme = "tls://";
inline bool is_tls(std::string_view address) {
  return address.starts_with(tls_scheme);
}

// "127.0.0.1:7801", "[::1]:7801", "localhost:7801". Port 0 is allowed: when listening, the system chooses one.
// Empty when the text is such an address, else what is wrong with it, as the end of a sentence.
std::string why_not_loopback(std::string_view text);
// Throws hal::ConfigError with one sentence when it is none.
boost::asio::ip::tcp::endpoint loopback_endpoint(std::string_view text);

// A machine by name or number, and a port on it: "roark.example.org:7444", "[2001:db8::7]:7444".
struct Host {
  std::string name;  // without brackets
  std::uint16_t port = 0;
};
// Empty when the text is such a one, else what is wrong with it, as the end of a sentence.
std::string why_no_host(std::string_view text);
// Throws hal::ConfigError with one sentence when it is none.
Host read_host(std::string_view text);
std::string to_text(const Host& host);

// What gateway.listen says: an address of this machine, for everybody when it begins with "tls://".
struct ListenAddress {
  boost::asio::ip::tcp::endpoint at;
  bool tls = false;
};
std::string why_not_listenable(std::string_view text);
// Throws hal::ConfigError with one sentence when it is none.
ListenAddress read_listen_address(std::string_view text);

std::string to_text(const boost::asio::ip::tcp::endpoint& endpoint);

}  // namespace arkmesh::gateway
