#include "gateway/links/links.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "gateway/address.hpp"
#include "gateway/federation/nats_address.hpp"

namespace arkmesh::gateway {
namespace {

struct Connect {
  std::string_view scheme, address;
};

Connect split(std::string_view connect) {
  constexpr std::string_view between = "://";
  const std::size_t end = connect.find(between);
  if (end == std::string_view::npos) return {"tcp", connect};
  return {connect.substr(0, end), connect.substr(end + between.size())};
}

// Null when there is none.
const LinkKind* find(std::string_view scheme) {
  const auto found = std::ranges::find(link_kinds(), scheme, &LinkKind::scheme);
  return found == link_kinds().end() ? nullptr : &*found;
}

}  // namespace

std::vector<LinkKind>& link_kinds() {
  static std::vector<LinkKind> kinds = {
      {"tcp", why_not_loopback,
       [](const LinkSurroundings& gateway, const std::string& peer, std::string_view address) {
         return gateway.node.link(peer, address);
       }},
      {"tls", why_no_host,
       [](const LinkSurroundings& gateway, const std::string& peer, std::string_view address) {
         return gateway.node.tls_link(peer, address);
       }},
      {"nats", why_no_open_servers,
       [](const LinkSurroundings& gateway, const std::string& peer, std::string_view address) {
         return gateway.node.federation_link(peer, address, false);
       }},
      {"tls+nats", why_no_servers,
       [](const LinkSurroundings& gateway, const std::string& peer, std::string_view address) {
         return gateway.node.federation_link(peer, address, true);
       }},
  };
  return kinds;
}

std::string why_not_connectable(std::string_view connect) {
  const auto [scheme, address] = split(connect);
  if (const LinkKind* kind = find(scheme)) return kind->why_not(address);
  std::string known;
  for (const LinkKind& kind : link_kinds()) known += (known.empty() ? "" : ", ") + kind.scheme + "://";
  return fmt::format("begins with '{}://', which is not a kind of link; there are: {}", scheme, known);
}

std::unique_ptr<Link> make_link(const LinkSurroundings& gateway, const PeerConfig& peer) {
  const auto [scheme, address] = split(peer.connect);
  if (const LinkKind* kind = find(scheme)) return kind->make(gateway, peer.lab, address);
  throw hal::ConfigError(fmt::format("address '{}' {}", peer.connect, why_not_connectable(peer.connect)));
}

}  // namespace arkmesh::gateway
