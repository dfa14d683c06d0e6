#include "view/patience.hpp"

#include <algorithm>

namespace arkmesh::view {
namespace {

namespace ip = boost::asio::ip;

// Who may choose their address freely counts as one: this machine has 2^24 of its own, a network of IPv6 2^64.
std::string network_of(ip::address from) {
  if (from.is_v6() && from.to_v6().is_v4_mapped()) from = ip::make_address_v4(ip::v4_mapped, from.to_v6());
  if (from.is_loopback()) return "loopback";
  if (from.is_v4()) return from.to_string();
  ip::address_v6::bytes_type bytes = from.to_v6().to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), static_cast<unsigned char>(0));
  return ip::address_v6(bytes).to_string();
}

}  // namespace

Patience::Wait Patience::after_wrong(const ip::address& from, Time now) {
  std::erase_if(known_, [now](const auto& one) { return now - one.second.last > forgets_after; });
  std::string who = network_of(from);
  if (known_.size() >= max_known && !known_.contains(who)) who.clear();
  Known& known = known_[who];
  known.last = now;
  const Wait wait = known.next;
  known.next = std::min(2 * wait, longest);
  return wait;
}

}  // namespace arkmesh::view
