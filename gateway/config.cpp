// Peers that take no part are read and checked too.
#include "gateway/config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "gateway/address.hpp"
#include "gateway/federation/nats_address.hpp"
#include "gateway/frame/channel_name.hpp"
#include "gateway/frame/frame.hpp"
#include "gateway/frame/hello.hpp"
#include "gateway/links/links.hpp"
#include "gateway/outbox/outbox.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/config/without_secrets.hpp"

namespace arkmesh::gateway {

namespace {

// A channel of a short form, as a rule about all peers.
void add_rule(const hal::Section& gateway, const char* key, Direction way, Delivery delivery,
              const std::string& channel, std::vector<ChannelRule>& rules) {
  if (!is_exported_name(channel))
    gateway.refuse(
        key,
        fmt::format("'{}' cannot be exported; a channel's name has 1 to {} printable characters without space and '/'",
                    channel, hal::max_channel_name));
  rules.push_back({.allow = channel,
                   .direction = way,
                   .delivery = delivery,
                   .key = fmt::format("gateway.{}", key),
                   .place = gateway.place(key)});
}

void check_address(const hal::Section& section, std::string_view key, const std::string& address,
                   std::string (*why_not)(std::string_view)) {
  if (address.empty()) return;
  if (const std::string why = why_not(address); !why.empty()) section.refuse(key, why);
}

}  // namespace

void PeerConfig::fields(const hal::Section& peer) {
  peer.field("lab", lab, {.help = "name of the peer", .sample = "\"roark\"", .required = true});
  peer.field(
      "connect", connect,
      {.help = "[SCHEME://]ADDRESS at which this gateway connects to it, for example tls://roark.example.org:7444; "
               "HOST:PORT means TCP on this machine. Empty: it connects to this gateway",
       .written = hal::without_secrets});
  peer.field("import_rate_hz", limits.rate_hz,
             {.range = {1e-3, 1e6},
              .unit = "Hz",
              .help = "limit of messages from this peer, over all channels; excess is refused",
              .sample = "1000",
              .default_is = "10000; arkmesh run: no limit"});
  peer.field("import_bytes_per_s", limits.bytes_per_s,
             {.range = {1, 1e12},
              .unit = "bytes/s",
              .help = "the same limit in bytes",
              .sample = "1000000",
              .default_is = "20000000; arkmesh run: no limit"});
}

void PeerConfig::check(const hal::Section& peer) const {
  check_address(peer, "connect", connect, why_not_connectable);
  if (!hal::is_lab_name(lab))
    peer.refuse("lab", fmt::format("is not a lab name; use 1 to {} of a-z, 0-9, '_' and '-'", hal::max_lab_name));
}

void GatewayConfig::fields(const hal::Section& gateway) {
  gateway.field("listen", listen,
                {.help = "[tls://]HOST:PORT on which to accept peers; without tls:// on 127.0.0.1 only"});
  gateway.field(
      "connect", connect,
      {.help = "[tls+]nats://HOST[:PORT],... : NATS servers where this lab meets those of shared.labs that have no "
               "entry in gateway.peers",
       .written = hal::without_secrets});
  gateway.field("server_ca", federation.server_ca,
                {.help = "file of the CA certificates for NATS servers; empty: the system's"});
  gateway.field("credentials", federation.credentials,
                {.help = "file of this lab's credentials for NATS servers (.creds); empty: none"});
  gateway.field("encrypt", federation.encrypt,
                {.help = "encrypt messages through NATS servers for the trusted labs; they are always signed"});
  gateway.field(
      "watched", watched,
      {.help = "channels that arkmesh view --federation receives, five samples a second; [] disables watching"});
  gateway.field("keys", keys,
                {.help = "folder of keys and trusted certificates (arkmesh keys); empty: ~/.config/arkmesh/keys"});
  gateway.field("exports", latest,
                {.help = "channels exported to all peers, newest message only; applied after gateway.rules"});
  gateway.field("ordered", ordered,
                {.help = "channels exported to all peers, every message in order; applied after gateway.rules"});
  gateway.field("imports", imports,
                {.help = "channels imported from all peers; applied after gateway.rules. Other channels are refused"});
  gateway.field("max_message_bytes", max_message_bytes,
                {{1 << 10, 64 << 20}, "bytes", "longer messages are neither sent nor accepted"});
  gateway.field("outbox_bytes", outbox_bytes, {{1 << 10, 1LL << 32}, "bytes", "limit of data waiting for one peer"});
  gateway.field("window_bytes", flow.bytes,
                {{4 << 10, 64 << 20},
                 "bytes",
                 "limit of unacknowledged data to one peer; the rest waits here, where newer values replace it"});
  gateway.field(
      "window_s", flow.delay,
      {{0.01, 10}, "s", "unacknowledged data is limited to what arrives within this time beyond the path's own delay"});
  gateway.field("metrics", metrics,
                {.help = "HOST:PORT on this machine that serves the values of `arkmesh status` to Prometheus at "
                         "/metrics, for example 127.0.0.1:9464; empty: none"});
  gateway.field("peers", peers);
  gateway.field("rules", first_rules);
}

// The rules of all keys, in the order in which they count.
void GatewayConfig::gather_rules(const hal::Section& gateway) {
  std::vector<ChannelRule> all = first_rules;
  std::vector<std::string> seen;
  const auto add_export = [&](const char* key, Delivery delivery, const std::string& channel) {
    add_rule(gateway, key, Direction::exports, delivery, channel, all);
    if (std::ranges::find(seen, channel) != seen.end())
      gateway.refuse(key, fmt::format("channel '{}' is listed twice in gateway.exports and gateway.ordered", channel));
    seen.push_back(channel);
  };
  for (const std::string& channel : latest) add_export("exports", Delivery::latest, channel);
  for (const std::string& channel : ordered) add_export("ordered", Delivery::ordered, channel);
  for (const std::string& channel : imports)
    add_rule(gateway, "imports", Direction::imports, Delivery::latest, channel, all);
  // Who takes commands answers them, and who gives them hears the answers.
  for (ChannelRule answers : std::vector(all)) {
    if (answers.allow != "operator_command") continue;
    answers.allow = "operator_answer";
    answers.delivery = answers.direction == Direction::imports ? Delivery::ordered : Delivery::latest;
    answers.direction = answers.direction == Direction::imports ? Direction::exports : Direction::imports;
    all.push_back(answers);
  }
  if (std::ranges::count(all, Direction::exports, &ChannelRule::direction) > std::ptrdiff_t{max_hello_channels})
    gateway.refuse("exports", fmt::format("at most {} channels can be exported", max_hello_channels));
  rules = ChannelRules(std::move(all));

  std::vector<std::string> labs;
  for (const PeerConfig& peer : peers) {
    labs.push_back(peer.lab);
    rules.limit(peer.lab, peer.limits);
  }
  if (connect.empty()) check_rules(gateway, labs);
}

// Of rules about single peers.
void GatewayConfig::check_rules(const hal::Section& gateway, const std::vector<std::string>& labs) const {
  for (std::size_t i = 0; i < first_rules.size(); ++i) {
    const hal::Section rule = gateway.section("rules", static_cast<int>(i));
    for (const std::string& lab : first_rules[i].peers)
      if (std::ranges::find(labs, lab) == labs.end())
        rule.refuse("peers", fmt::format("lab {} has no entry in gateway.peers; add one or correct the name", lab));
  }
}

void GatewayConfig::check(const hal::Section& gateway) {
  check_address(gateway, "listen", listen, why_not_listenable);
  check_address(gateway, "connect", connect, [](std::string_view address) {
    return is_nats(address)
               ? why_not_connectable(address)
               : std::string("must begin with nats:// or tls+nats://; one lab's address belongs in gateway.peers");
  });
  check_address(gateway, "metrics", metrics, why_not_loopback);
  for (const std::string& channel : watched)
    if (!is_exported_name(channel) || commands_robots(channel))
      gateway.refuse("watched", fmt::format("channel '{}' cannot be watched", channel));
  gather_rules(gateway);
  const std::size_t frames = max_message_bytes / max_frame_payload_bytes + 2;
  const std::size_t more = Outbox::overhead_bytes + frames * frame_header_bytes + max_hello_bytes;
  if (outbox_bytes < max_message_bytes + more)
    gateway.refuse("outbox_bytes",
                   fmt::format("must be at least gateway.max_message_bytes = {} and {} more, so that the largest "
                               "message fits",
                               max_message_bytes, more));
}

bool GatewayConfig::needs_keys() const {
  return is_tls(listen) || std::ranges::any_of(peers, is_tls, &PeerConfig::connect) || is_federated();
}

bool GatewayConfig::is_federated() const {
  return std::ranges::any_of(peers, is_nats, &PeerConfig::connect);
}

GatewayConfig read_gateway_config(const hal::Section& gateway, const std::string& lab,
                                  const std::vector<std::string>& labs) {
  auto config = gateway.read<GatewayConfig>();
  std::vector<std::string> seen;
  std::vector<PeerConfig> all = std::exchange(config.peers, {});
  bool listens = false;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const hal::Section section = gateway.section("peers", static_cast<int>(i));
    PeerConfig& peer = all[i];
    if (peer.lab == lab) section.refuse("lab", "is this lab itself; list only its peers");
    if (std::ranges::find(seen, peer.lab) != seen.end()) section.refuse("lab", "is listed twice; one entry per peer");
    seen.push_back(peer.lab);
    if (std::ranges::find(labs, peer.lab) == labs.end()) {
      config.ignored.push_back(peer.lab);
      continue;
    }
    if (config.listen.empty() && peer.connect.empty()) peer.connect = config.connect;
    if (peer.connect.empty() && config.listen.empty())
      section.refuse("lab", "has no `connect`, so gateway.listen must say where its connection is accepted");
    listens |= peer.connect.empty();
    config.peers.push_back(std::move(peer));
  }
  if (!config.connect.empty()) {
    for (const std::string& each : labs)
      if (each != lab && std::ranges::find(seen, each) == seen.end()) {
        seen.push_back(each);
        config.peers.push_back({each, config.connect, {}});
      }
    config.check_rules(gateway, seen);
  }
  if (!listens) config.listen.clear();
  return config;
}

}  // namespace arkmesh::gateway
