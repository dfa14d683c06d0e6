#include "gateway/channel_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gateway/channel_name.hpp"
#include "hal/messages.hpp"

namespace arkmesh::gateway {

void ChannelRule::fields(const hal::Section& rule) {
  rule.field("allow", allow,
             {.help = "channels that pass; '*' stands for any characters, but never means commands to robots",
              .sample = "\"world\""});
  rule.field("deny", deny, {.help = "in place of allow: channels that do not pass"});
  rule.field(
      "direction", direction,
      {.help = "to the peers or from them", .one_of = {"export", "import"}, .sample = "\"export\"", .required = true});
  rule.field("peers", peers, {.help = "the labs that it is about. Empty: all"});
  rule.field("rename", rename,
             {.help = "what the channel is called at the peer, or behind PEER/ here. Empty: as it was"});
  rule.field("delivery", delivery,
             {.help = "of exports: whether the newest message counts or every one", .one_of = {"latest", "ordered"}});
  rule.field(
      "rate_hz", rate_hz,
      {.range = {1e-3, 1e6},
       .unit = "Hz",
       .help = "of each channel and peer. What is more waits, and of \"latest\" only the newest; of imports it is "
               "refused, and a second's worth may come at once",
       .sample = "10",
       .default_is = "no limit"});
  rule.field("bytes_per_s", bytes_per_s,
             {.range = {1, 1e12},
              .unit = "bytes/s",
              .help = "the same of bytes",
              .sample = "100000",
              .default_is = "no limit"});
  rule.field("max_age_s", max_age_s,
             {.range = {1e-3, 1e6},
              .unit = "s",
              .help = "of exports: what has waited longer is dropped",
              .sample = "1",
              .default_is = "no limit"});
  rule.field("priority", priority,
             {.help = "of exports: everything that waits of a higher priority goes first",
              .one_of = {"low", "normal", "high"}});
  rule.field("compress", compress, {.help = "of exports: messages go compressed, where that is shorter"});
}

void ChannelRule::check(const hal::Section& rule) {
  if (allow.empty() && deny.empty())
    rule.refuse("", "says neither allow = \"CHANNEL\" nor deny = \"CHANNEL\"; write one of them");
  if (!allow.empty() && !deny.empty()) rule.refuse("deny", "stands beside `allow`; a rule has one of them");
  const char* const kind = allows() ? "allow" : "deny";
  if (!is_exported_name(pattern()))
    rule.refuse(kind, fmt::format("is no channel that can cross; a name has 1 to {} printable characters without space "
                                  "and '/', and '*' stands for any of them",
                                  hal::max_channel_name));
  for (const std::string& peer : peers)
    if (!hal::is_lab_name(peer)) rule.refuse("peers", fmt::format("'{}' is no lab name", peer));
  if (!rename.empty()) {
    if (!allows()) rule.refuse("rename", "means nothing in a rule that denies; remove it");
    if (has_wildcard(allow))
      rule.refuse("rename", "gives all channels of a pattern one name; write a rule for each of them");
    if (!is_exported_name(rename) || has_wildcard(rename))
      rule.refuse("rename", fmt::format("is no channel name; use 1 to {} printable characters without space, '/' "
                                        "and '*'; the lab's name is put before it by itself",
                                        hal::max_channel_name));
    if (rename == allow) rename.clear();
  }
  const bool is_export = allows() && direction == Direction::exports;
  for (const auto& [name, is_given] :
       {std::pair("delivery", delivery != Delivery::latest), std::pair("compress", compress),
        std::pair("priority", priority != Priority::normal), std::pair("max_age_s", !std::isnan(max_age_s))})
    if (is_given && !is_export) rule.refuse(name, "means something in a rule that allows an export only; remove it");
  for (const auto& [name, limit] : {std::pair("rate_hz", rate_hz), std::pair("bytes_per_s", bytes_per_s)})
    if (!std::isnan(limit) && !allows()) rule.refuse(name, "means nothing in a rule that denies; remove it");
  key = rule.path();
  place = rule.place(kind);
}

bool ChannelRule::is_about(Direction way, std::string_view channel, std::string_view peer) const {
  return direction == way && (peers.empty() || std::ranges::find(peers, peer) != peers.end()) &&
         matches(pattern(), channel) && !(allows() && has_wildcard(allow) && commands_robots(channel));
}

Rule ChannelRule::on_link(const std::string& channel) const {
  const auto limit = [](double value) { return std::isnan(value) ? Rule::unlimited : value; };
  return {.channel = name_of(channel),
          .delivery = delivery,
          .priority = priority,
          .compress = compress,
          .rate_hz = limit(rate_hz),
          .bytes_per_s = limit(bytes_per_s),
          .max_age_s = limit(max_age_s)};
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
    ExportedChannel channel = exported(rule.allow);
    channel.name = rule.name_of(rule.allow);
    const auto same = std::ranges::find(all, channel.name, &ExportedChannel::name);
    if (same == all.end())
      all.push_back(std::move(channel));
    else if (same->type != channel.type)
      same->type = 0;
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

std::optional<ChannelRules::Collision> ChannelRules::collision(const std::vector<std::string>& peers) const {
  // Names that no rename mentions keep their own, so only those can collide that a rename takes or gives.
  std::vector<std::string> names;
  for (const ChannelRule& rule : rules_)
    if (!rule.rename.empty()) names.insert(names.end(), {rule.allow, rule.rename});
  for (const std::string& peer : peers)
    for (const Direction way : {Direction::exports, Direction::imports}) {
      std::map<std::string, std::string> came_from;
      for (const std::string& name : names) {
        const ChannelRule* const rule = passing(way, name, peer);
        if (!rule) continue;
        const std::string& out = rule->name_of(name);
        const auto [place, is_new] = came_from.emplace(out, name);
        if (is_new || place->second == name) continue;
        const ChannelRule* const other = passing(way, place->second, peer);
        const ChannelRule* const renaming = rule->rename.empty() ? other : rule;
        return Collision{static_cast<std::size_t>(renaming - rules_.data()),
                         fmt::format("makes one channel of {} and {} {} lab {}; choose another name, or deny one of "
                                     "the two in a rule before",
                                     place->second, name, way == Direction::exports ? "for" : "from", peer)};
      }
    }
  return {};
}

}  // namespace arkmesh::gateway
