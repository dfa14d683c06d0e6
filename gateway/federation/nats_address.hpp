// Where a federation meets: the servers of gateway.connect. Pure.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "gateway/address.hpp"

namespace arkmesh::gateway {

struct NatsServer {
  Host host;
  std::string user, password;  // empty: none
};

struct NatsServers {
  bool tls = false;
  std::vector<NatsServer> all;  // in the order in which they are tried
};

// "a.example.org:4222, b.example.org", what follows nats:// or tls+nats://; the port is 4222 unless it says another.
// Each may begin with USER:PASSWORD@ and with the scheme once more.
// Empty when the text is such a list, else what is wrong with it, as the end of a sentence.
std::string why_no_servers(std::string_view text);
// Likewise; without encryption a password goes to a server on this machine only.
std::string why_no_open_servers(std::string_view text);
// Throws hal::ConfigError with one sentence when it is none.
NatsServers read_servers(std::string_view text, bool tls);

// Whether gateway.connect or gateway.peers.connect means a federation.
inline bool is_nats(std::string_view connect) {
  return connect.starts_with("nats://") || connect.starts_with("tls+nats://");
}

}  // namespace arkmesh::gateway
