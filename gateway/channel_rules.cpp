#include "gateway/channel_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gateway/frame/channel_name.hpp"
#include "hal/arenas/messages.hpp"

namespace arkmesh::gateway {

void ChannelRule::fields(const hal::Section& rule) {
  rule.field("allow", allow,
             {.help = "channels to pass; '*' matches any characters, but never channels of commands to robots",
              .sample = "\"world\""});
  rule.field("deny", deny, {.help = "channels to block, instead of allow"});
  rule.field("direction", direction,
             {.help = "exports go to the peers, imports come from them",
              .one_of = {"export", "import"},
              .sample = "\"export\"",
              .required = true});
  rule.field("peers", peers, {.help = "labs to which the rule applies; empty: all"});
  rule.field("delivery", delivery,
             {.help = "delivery of exports: the newest message only, or every message in order",
              .one_of = {"latest", "ordered"}});
  rule.field("rate_hz", rate_hz,
             {.range = {1e-3, 1e6},
              .unit = "Hz",
              .help = "rate limit per channel and peer. Excess exports wait (of \"latest\" only the newest); excess "
                      "imports are refused, after a burst of one second's worth",
              .sample = "10",
              .default_is = "no limit"});
  rule.field("bytes_per_s", bytes_per_s,
             {.range = {1, 1e12},
              .unit = "bytes/s",
              .help = "the same limit in bytes",
              .sample = "100000",
              .default_is = "no limit"});
}

void ChannelRule::check(const hal::Section& rule) {
  if (allow.empty() && deny.empty())
    rule.refuse("", "has neither allow = \"CHANNEL\" nor deny = \"CHANNEL\"; write one of them");
  if (!allow.empty() && !deny.empty()) rule.refuse("deny", "cannot be combined with `allow`; a rule has one of them");
  const char* const kind = allows() ? "allow" : "deny";
  if (!is_exported_name(pattern()))
    rule.refuse(kind, fmt::format("is not a channel that can cross; a name has 1 to {} printable characters without "
                                  "space and '/', and '*' matches any of them",
                                  hal::max_channel_name));
  for (const std::string& peer : peers)
    if (!hal::is_lab_name(peer)) rule.refuse("peers", fmt::format("'{}' is not a lab name", peer));
  if (delivery != Delivery::latest && !(allows() && direction == Direction::exports))
    rule.refuse("delivery", "applies only to a rule that allows an export; remove it");
  for (const auto& [name, limit] : {std::pair("rate_hz", rate_hz), std::pair("bytes_per_s", bytes_per_s)})
    if (!std::isnan(limit) && !allows()) rule.refuse(name, "does not apply to a rule that denies; remove it");
  key = rule.path();
  place = rule.place(kind);
}

bool ChannelRule::is_about(Direction way, std::string_view channel, std::string_view peer) const {
  return direction == way && (peers.empty() || std::ranges::find(peers, peer) != peers.end()) &&
         matches(pattern(), channel) && !(allows() && has_wildcard(allow) && commands_robots(channel));
}

Rule ChannelRule::on_link(const std::string& channel) const {
  const auto limit = [](double value) { return std::isnan(value) ? Rule::unlimited : value; };
  return {.channel = channel, .delivery = delivery, .rate_hz = limit(rate_hz), .bytes_per_s = limit(bytes_per_s)};
}

PeerLimits PeerLimits::or_usual() const {
  return {std::isnan(rate_hz) ? usual_rate_hz : rate_hz, std::isnan(bytes_per_s) ? usual_bytes_per_s : bytes_per_s};
}

ChannelRules::ChannelRules(const std::vector<Rule>& exports, const std::vector<std::string>& imports) {
  for (const Rule& rule : exports) rules_.push_back({.allow = rule.channel, .delivery = rule.delivery});
  for (const std::string& channel : imports) rules_.push_back({.allow = channel, .direction = Direction::imports});
}

const ChannelRule* ChannelRules::about(Direction way, std::string_view channel, std::string_view peer) const {
  const auto rule = std::ranges::find_if(rules_, [&](const auto& each) { return each.is_about(way, channel, peer); });
  return rule == rules_.end() ? nullptr : &*rule;
}

const ChannelRule* ChannelRules::passing(Direction way, std::string_view channel, std::string_view peer) const {
  const ChannelRule* const rule = about(way, channel, peer);
  return rule && rule->allows() ? rule : nullptr;
}

PeerLimits ChannelRules::limits_of(std::string_view peer) const {
  const auto found = limits_.find(peer);
  return found == limits_.end() ? PeerLimits() : found->second;
}

std::vector<ExportedChannel> ChannelRules::announced(const std::vector<std::string>& peers) const {
  std::vector<ExportedChannel> all;
  for (const ChannelRule& rule : rules_) {
    if (!rule.allows() || rule.direction != Direction::exports) continue;
    // A name that earlier rules decide is not this one's.
    const auto decides = [&](const std::string& peer) { return about(Direction::exports, rule.allow, peer) == &rule; };
    if (!has_wildcard(rule.allow) && std::ranges::none_of(peers, decides)) continue;
    if (std::ranges::find(all, rule.allow, &ExportedChannel::name) == all.end()) all.push_back(exported(rule.allow));
  }
  return all;
}

std::string ChannelRules::bus_pattern() const {
  std::string all;
  for (const ChannelRule& rule : rules_)
    if (rule.allows() && rule.direction == Direction::exports)
      (all += all.empty() ? "" : "|") += lcm_pattern(rule.allow);
  return all;
}

}  // namespace arkmesh::gateway
