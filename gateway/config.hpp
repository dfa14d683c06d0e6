// The keys of [gateway].
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "gateway/channel_rules.hpp"
#include "gateway/federation/options.hpp"
#include "gateway/outbox/flow_window.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::gateway {

struct PeerConfig {
  std::string lab;
  std::string connect;  // [SCHEME://]ADDRESS, where that lab's gateway listens (links.hpp); empty: it connects to us
  PeerLimits limits;

  void fields(const hal::Section& peer);
  void check(const hal::Section& peer) const;
};

struct GatewayConfig {
  // [tls://]HOST:PORT on this machine, for peers without `connect`. Emptied when there is no such peer.
  std::string listen;
  std::string connect;           // [tls+]nats://SERVERS where labs without `connect` meet
  FederationOptions federation;  // gateway.server_ca, .credentials, .encrypt
  // Channels that who watches a federation gets samples of.
  std::vector<std::string> watched{"arena", "overlay", "peers", "poses", "shared", "shown", "status"};
  std::filesystem::path keys;                           // the folder of keys; empty: KeyFolder::default_folder()
  std::vector<std::string> latest{"world", "status"};   // gateway.exports: the newest message counts
  std::vector<std::string> ordered;                     // gateway.ordered: all of them count
  std::vector<std::string> imports{"world", "status"};  // channels that peers may publish here
  std::vector<ChannelRule> first_rules;                 // gateway.rules
  ChannelRules rules;                                   // these and, after them, the three short forms
  std::size_t outbox_bytes = 4 << 20;                   // what may wait for one peer, everything included
  std::uint32_t max_message_bytes = 1 << 20;            // longer messages are not sent and not taken
  std::string metrics;                                  // HOST:PORT on this machine for Prometheus; empty: none
  FlowLimits flow;                                      // what may be under way to one peer
  std::vector<PeerConfig> peers;                        // those of gateway.peers that take part, and who is met there
  std::vector<std::string> ignored;                     // the others: not in shared.labs

  void fields(const hal::Section& gateway);
  void check(const hal::Section& gateway);
  // Whether a peer is met in a federation.
  bool is_federated() const;
  // Whether anything of it is TLS, or signed.
  bool needs_keys() const;

 private:
  friend GatewayConfig read_gateway_config(const hal::Section& gateway, const std::string& lab,
                                           const std::vector<std::string>& labs);
  void gather_rules(const hal::Section& gateway);
  void check_rules(const hal::Section& gateway, const std::vector<std::string>& labs) const;
};

// `lab`: this one; `labs`: shared.labs. Throws ConfigError.
GatewayConfig read_gateway_config(const hal::Section& gateway, const std::string& lab,
                                  const std::vector<std::string>& labs);

}  // namespace arkmesh::gateway
