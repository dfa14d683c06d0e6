// The rules of labs' gateways, read from their files, and what they make of a channel on its way between two labs.
#pragma once

#include <string>

#include "gateway/config.hpp"
#include "gateway/explanation.hpp"

namespace arkmesh::gateway {

// A lab's file, as far as it is about its gateway.
struct LabRules {
  std::string file, lab;
  GatewayConfig config;

  // Throws hal::ConfigError.
  explicit LabRules(const std::string& path);
  // Throws hal::ConfigError when the lab has no such peer.
  Explanation explain(Direction way, const std::string& channel, const std::string& peer) const;
};

// From the sender's side to the receiver's, as far as their files are given: one of them may be null. `channel` as its
// own lab calls it. Throws hal::ConfigError.
Explanation explain_way(const std::string& channel, const std::string& sender, const LabRules* from,
                        const std::string& receiver, const LabRules* to);

}  // namespace arkmesh::gateway
