#include "gateway/explanation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gateway/frame/channel_name.hpp"
#include "hal/arenas/messages.hpp"

namespace arkmesh::gateway {

namespace {

// "rule 2 (gateway.rules[1], shark.toml:5: allow = "cam_*")"
std::string name_rule(const ChannelRules& rules, const ChannelRule& rule) {
  return fmt::format("rule {} ({}, {}: {} = \"{}\")", &rule - rules.all().data() + 1, rule.key,
                     rule.place.empty() ? "by default" : rule.place, rule.allows() ? "allow" : "deny", rule.pattern());
}

std::string settings_of(const ChannelRule& rule, Direction way) {
  std::string text;
  const auto add = [&](std::string_view what, std::string_view value) {
    text += fmt::format("  {:<12}{}\n", what, value);
  };
  const char* const beyond = way == Direction::imports ? "more are refused"
                             : rule.delivery == Delivery::latest
                                 ? "between these, a newer message replaces an older one"
                                 : "more wait while there is room";
  if (!std::isnan(rule.rate_hz)) add("at most", fmt::format("{:g} messages/s; {}", rule.rate_hz, beyond));
  if (!std::isnan(rule.bytes_per_s)) add("at most", fmt::format("{:g} bytes/s; {}", rule.bytes_per_s, beyond));
  if (way == Direction::imports) return text;
  add("delivery", rule.delivery == Delivery::latest ? "latest: a newer message replaces one that waits"
                                                    : "ordered: every message counts");
  return text;
}

std::string rule_to_write(Direction way, const std::string& channel, const std::string& peer) {
  return fmt::format("    [[gateway.rules]]\n    allow = \"{}\"\n    direction = \"{}\"\n    peers = [\"{}\"]\n",
                     channel, way == Direction::exports ? "export" : "import", peer);
}

}  // namespace

Explanation explain(const ExplainedLab& lab, Direction way, const std::string& channel, const std::string& peer) {
  const bool out = way == Direction::exports;
  const std::string what = fmt::format("{} {} {} {}", out ? "export" : "import", channel, out ? "to" : "from", peer);
  if (!is_exported_name(channel) || has_wildcard(channel))
    return {.text = fmt::format("lab {} does not {}: a channel that can cross has 1 to {} printable characters without "
                                "space, '/' and '*'; messages from another lab are not passed on\n",
                                lab.name, what, hal::max_channel_name)};

  const ChannelRule* const rule = lab.rules.about(way, channel, peer);
  if (rule && rule->allows()) {
    return {.passes = true,
            .text = fmt::format("lab {} {}s {} {} {} as {}: {}\n", lab.name, out ? "export" : "import", channel,
                                out ? "to" : "from", peer, foreign_name(out ? lab.name : peer, channel),
                                name_rule(lab.rules, *rule)) +
                    settings_of(*rule, way)};
  }
  if (rule)
    return {.text =
                fmt::format("lab {} does not {}: {} denies it\n  to let it pass, write before that rule in {}:\n{}",
                            lab.name, what, name_rule(lab.rules, *rule), lab.file, rule_to_write(way, channel, peer))};
  const bool is_command =
      commands_robots(channel) && std::ranges::any_of(lab.rules.all(), [&](const ChannelRule& each) {
        return each.direction == way && each.allows() && matches(each.allow, channel);
      });
  return {
      .text = fmt::format(
          "lab {} does not {}: no rule allows it{}\n  to let it pass, add \"{}\" to gateway.{} in {}, or, for lab {} "
          "alone:\n{}",
          lab.name, what, is_command ? ", for '*' never means commands to robots" : "", channel,
          out ? "exports" : "imports", lab.file, peer, rule_to_write(way, channel, peer))};
}

}  // namespace arkmesh::gateway
