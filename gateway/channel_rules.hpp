// Which channels cross between this lab and its peers, and in which direction. The first rule about a channel decides;
// what no rule is about does not cross. Pure.
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/frame/hello.hpp"
#include "gateway/link.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::gateway {

inline constexpr double not_given = std::numeric_limits<double>::quiet_NaN();

enum class Direction { exports, imports };

// One [[gateway.rules]], or one name of the short forms gateway.exports, .ordered and .imports.
struct ChannelRule {
  std::string allow, deny;  // the channels that it is about, '*' for any characters; one of the two
  Direction direction = Direction::exports;
  std::vector<std::string> peers;  // labs that it is about; empty: all
  Delivery delivery = Delivery::latest;
  // Of each channel and peer; a NaN is no limit.
  double rate_hz = not_given, bytes_per_s = not_given;
  std::string key;    // "gateway.rules[1]"
  std::string place;  // "shark.toml:12"; empty when no file says it

  void fields(const hal::Section& rule);
  void check(const hal::Section& rule);
  bool allows() const { return !allow.empty(); }
  const std::string& pattern() const { return allows() ? allow : deny; }
  bool is_about(Direction way, std::string_view channel, std::string_view peer) const;
  // How it goes to a peer.
  Rule on_link(const std::string& channel) const;
};

// What a peer may publish here in all; a NaN is no limit.
struct PeerLimits {
  double rate_hz = not_given, bytes_per_s = not_given;

  // Where each lab is a process of its own. Two labs of 1000 robots at a hundred times real time need 100 messages and
  // 5 MB in a second.
  static constexpr double usual_rate_hz = 10'000, usual_bytes_per_s = 20e6;
  PeerLimits or_usual() const;
};

class ChannelRules {
 public:
  ChannelRules() = default;
  explicit ChannelRules(std::vector<ChannelRule> rules) : rules_(std::move(rules)) {}
  // These to all peers, and those from all of them.
  ChannelRules(const std::vector<Rule>& exports, const std::vector<std::string>& imports);

  // In the order in which they count.
  const std::vector<ChannelRule>& all() const { return rules_; }
  // The first rule that is about it; null when there is none.
  const ChannelRule* about(Direction way, std::string_view channel, std::string_view peer) const;
  // The same, when that rule allows it.
  const ChannelRule* passing(Direction way, std::string_view channel, std::string_view peer) const;

  PeerLimits limits_of(std::string_view peer) const;
  void limit(const std::string& peer, const PeerLimits& limits) { limits_[peer] = limits; }

  // What the peers are told to expect: names, and patterns as long as names.
  std::vector<ExportedChannel> announced(const std::vector<std::string>& peers) const;
  // The LCM patterns of all that a peer may get.
  std::string bus_pattern() const;

 private:
  std::vector<ChannelRule> rules_;
  std::map<std::string, PeerLimits, std::less<>> limits_;
};

}  // namespace arkmesh::gateway
