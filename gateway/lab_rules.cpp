#include "gateway/lab_rules.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "hal/bus/participants.hpp"

namespace arkmesh::gateway {

LabRules::LabRules(const std::string& path) : file(path) {
  const hal::Config read = hal::Config::from_file(path);
  const hal::Section root = read.root();
  const auto shared = root.read<hal::Participants>();
  lab = shared.lab;
  config = read_gateway_config(root.section("gateway"), lab, shared.labs);
  read.refuse_unknown("gateway");
}

Explanation LabRules::explain(Direction way, const std::string& channel, const std::string& peer) const {
  std::vector<std::string> peers = config.ignored;
  for (const PeerConfig& each : config.peers) peers.push_back(each.lab);
  if (std::ranges::find(peers, peer) == peers.end())
    throw hal::ConfigError(fmt::format("{}: lab {} has no peer {}; gateway.peers names {}", file, lab, peer,
                                       peers.empty() ? "nobody" : fmt::format("{}", fmt::join(peers, ", "))));
  if (std::ranges::find(config.ignored, peer) != config.ignored.end())
    return {.text = fmt::format("lab {} does not take part: shared.labs of {} does not list it\n", peer, file)};
  return gateway::explain({lab, file, config.rules}, way, channel, peer);
}

Explanation explain_way(const std::string& channel, const std::string& sender, const LabRules* from,
                        const std::string& receiver, const LabRules* to) {
  Explanation out{.passes = true, .text = {}};
  if (from) {
    out = from->explain(Direction::exports, channel, receiver);
    if (!out.passes) return out;
    if (!to)
      out.text += fmt::format("Whether lab {} takes it, its file says: arkmesh explain {} --from {} FILE\n", receiver,
                              channel, sender);
  }
  if (!to) return out;
  Explanation here = to->explain(Direction::imports, channel, sender);
  here.text.insert(0, out.text);
  return here;
}

}  // namespace arkmesh::gateway
