// Text as [gateway] of a lab's file, and names as a peer or the lab's bus may give them. Whatever the file says that is
// not refused: nothing of a peer's is published but directly below the peer's name, no pattern allows commands to
// robots, and what is explained is what happens.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/config.hpp"
#include "gateway/explanation.hpp"
#include "gateway/frame/channel_name.hpp"

namespace {

using namespace arkmesh::gateway;
using arkmesh::hal::Config;

void require(bool condition) {
  if (!condition) std::abort();
}

// The names that the file mentions, and those that the input ends with.
std::vector<std::string> names_to_try(const ChannelRules& rules, std::string_view more) {
  std::vector<std::string> names{"operator_command", "fleet_command", "to_robots", "world", "a", ""};
  for (const ChannelRule& rule : rules.all()) names.push_back(rule.pattern());
  while (!more.empty()) {
    const std::size_t end = std::min(more.find('\n'), more.size());
    names.emplace_back(more.substr(0, end));
    more.remove_prefix(std::min(end + 1, more.size()));
  }
  return names;
}

void try_rules(const ChannelRules& rules, const std::vector<std::string>& names, const std::string& peer) {
  for (const Direction way : {Direction::exports, Direction::imports}) {
    for (const std::string& name : names) {
      const Explanation explanation = explain({"shark", "shark.toml", rules}, way, name, peer);
      const ChannelRule* const rule = is_exported_name(name) ? rules.passing(way, name, peer) : nullptr;
      if (has_wildcard(name)) continue;
      require(explanation.passes == (rule != nullptr));
      if (!rule) continue;
      require(foreign_name(peer, name).rfind('/') == peer.size());
      require(!commands_robots(name) || rule->allow == name);
      if (way == Direction::imports) continue;
      bool is_announced = false;
      for (const ExportedChannel& channel : rules.announced({peer})) is_announced |= matches(channel.name, name);
      require(is_announced);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::size_t zero = std::min(input.find('\0'), input.size());
  try {
    const Config file = Config::from_text(input.substr(0, zero), "shark.toml");
    const GatewayConfig config =
        read_gateway_config(file.root().section("gateway"), "shark", {"lynx", "roark", "shark"});
    const auto names = names_to_try(config.rules, zero < size ? input.substr(zero + 1) : std::string_view());
    for (const PeerConfig& peer : config.peers) try_rules(config.rules, names, peer.lab);
  } catch (const arkmesh::hal::ConfigError&) {
  }
  if (const auto channels = read_channels(std::as_bytes(std::span(input))))
    require(encode_channels(*channels).size() == size);
  // A pattern of a peer's against a name of its own.
  if (size < 200) matches(input.substr(0, size / 2), input.substr(size / 2));
  return 0;
}
