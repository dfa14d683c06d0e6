// The only place where kinds of links are named: one line each. gateway.peers.connect is SCHEME://ADDRESS, and SCHEME
// chooses; without one it is TCP's.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/config.hpp"
#include "gateway/link.hpp"
#include "gateway/links/connections.hpp"

namespace arkmesh::gateway {

// The gateway that a link belongs to; all of it outlives the link.
struct LinkSurroundings {
  boost::asio::io_context& io;
  Connections& node;  // where TCP's connections are accepted
  const std::string& lab;
  std::uint64_t boot_id;  // grows with each start of this lab's gateway; never 0
  const GatewayConfig& config;
};

struct LinkKind {
  std::string scheme;
  // Empty when such a link can use the address, else what is wrong with it, as the end of a sentence.
  std::string (*why_not)(std::string_view address);
  std::unique_ptr<Link> (*make)(const LinkSurroundings& gateway, const std::string& peer, std::string_view address);
};

// All kinds of links that this build knows. A program of your own may add its own before it reads configurations.
std::vector<LinkKind>& link_kinds();

// Empty when a link can be made of gateway.peers.connect, else what is wrong with it, as the end of a sentence.
std::string why_not_connectable(std::string_view connect);
// The link to one peer. Throws hal::ConfigError when there is no such kind or it cannot use the address.
std::unique_ptr<Link> make_link(const LinkSurroundings& gateway, const PeerConfig& peer);

}  // namespace arkmesh::gateway
