// Reads every key of [gateway], also those of peers that take no part, so that none of them is unknown.
#include "gateway/config.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "gateway/address.hpp"
#include "gateway/channel_name.hpp"
#include "gateway/hello.hpp"
#include "gateway/links.hpp"
#include "gateway/outbox.hpp"
#include "hal/messages.hpp"

namespace arkmesh::gateway {

namespace {

void read_rules(const hal::Section& gateway, std::string_view key, Delivery delivery,
                const std::vector<std::string>& otherwise, std::vector<Rule>& rules) {
  for (const std::string& channel : gateway.texts(key, otherwise)) {
    if (!is_exported_name(channel))
      gateway.refuse(
          key, fmt::format("'{}' is no channel that can be exported; a name has 1 to {} printable characters without "
                           "space and '/'",
                           channel, hal::max_channel_name));
    if (std::ranges::find(rules, channel, &Rule::channel) != rules.end())
      gateway.refuse(key, fmt::format("channel '{}' is listed twice in gateway.exports and gateway.ordered", channel));
    rules.push_back({channel, delivery});
  }
  if (rules.size() > max_hello_channels)
    gateway.refuse(key, fmt::format("at most {} channels can be exported", max_hello_channels));
}

// An address with which nothing is wrong, or empty.
std::string read_address(const hal::Section& section, std::string_view key, std::string (*why_not)(std::string_view)) {
  const std::string address = section.text(key, "");
  if (address.empty()) return address;
  if (const std::string why = why_not(address); !why.empty()) section.refuse(key, why);
  return address;
}

}  // namespace

GatewayConfig read_gateway_config(const hal::Section& gateway, const std::string& lab,
                                  const std::vector<std::string>& labs) {
  GatewayConfig config;
  config.listen = read_address(gateway, "listen", why_not_loopback);
  read_rules(gateway, "exports", Delivery::latest, {hal::channel::world, hal::channel::status}, config.exports);
  read_rules(gateway, "ordered", Delivery::ordered, {}, config.exports);
  config.max_message_bytes =
      static_cast<std::uint32_t>(gateway.integer("max_message_bytes", config.max_message_bytes, 1 << 10, 64 << 20));
  config.outbox_bytes = static_cast<std::size_t>(
      gateway.integer("outbox_bytes", static_cast<std::int64_t>(config.outbox_bytes), 1 << 10, 1LL << 32));
  if (config.outbox_bytes < config.max_message_bytes + Outbox::overhead_bytes + max_hello_bytes)
    gateway.refuse("outbox_bytes",
                   fmt::format("must be at least gateway.max_message_bytes = {} and {} more, so that the largest "
                               "message fits",
                               config.max_message_bytes, Outbox::overhead_bytes + max_hello_bytes));

  std::vector<std::string> seen;
  bool listens = false;
  for (const hal::Section& section : gateway.sections("peers")) {
    PeerConfig peer{section.required_text("lab"), read_address(section, "connect", why_not_connectable)};
    if (!hal::is_lab_name(peer.lab))
      section.refuse("lab", fmt::format("is no lab name; use 1 to {} of a-z, 0-9, '_' and '-'", hal::max_lab_name));
    if (peer.lab == lab) section.refuse("lab", "is this lab itself; list its peers only");
    if (std::ranges::find(seen, peer.lab) != seen.end()) section.refuse("lab", "is listed twice; one entry per peer");
    seen.push_back(peer.lab);
    if (std::ranges::find(labs, peer.lab) == labs.end()) {
      config.ignored.push_back(peer.lab);
      continue;
    }
    if (peer.connect.empty() && config.listen.empty())
      section.refuse("lab", "has no `connect`, so gateway.listen must say where its connection is accepted");
    listens |= peer.connect.empty();
    config.peers.push_back(std::move(peer));
  }
  if (!listens) config.listen.clear();
  return config;
}

}  // namespace arkmesh::gateway
