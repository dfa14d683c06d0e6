#include "gateway/process_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hal/arenas/experiment.hpp"
#include "hal/bus/participants.hpp"

namespace arkmesh::gateway {

ProcessConfig read_process_config(const hal::Config& config) {
  const hal::Section root = config.root();
  ProcessConfig out;
  const auto shared = root.read<hal::Participants>();
  out.lab = shared.lab;
  hal::Experiment by_default{root.section("run").get("scenario", std::string())};
  out.experiment = root.section("shared").read(std::move(by_default)).id;
  out.bus = root.section("bus").read<hal::BusConfig>();
  out.gateway = read_gateway_config(root.section("gateway"), out.lab, shared.labs);
  for (const PeerConfig& peer : out.gateway.peers) out.gateway.rules.limit(peer.lab, peer.limits.or_usual());
  config.refuse_unknown("gateway");
  for (const std::string& lab : shared.labs)
    if (lab != out.lab && std::ranges::find(out.gateway.peers, lab, &PeerConfig::lab) == out.gateway.peers.end())
      root.section("gateway").refuse("peers",
                                     fmt::format("has no entry for lab {}, which shared.labs names; add one", lab));
  return out;
}

std::map<std::string, std::string, std::less<>> fixed_keys(const hal::Config& config) {
  std::map<std::string, std::string, std::less<>> all;
  for (const char* table : {"lab", "shared", "run", "bus", "gateway"}) all.merge(config.in_force_below(table));
  std::erase_if(all, [](const auto& entry) {
    const std::string& key = entry.first;
    return key.starts_with("gateway.rules") || key == "gateway.exports" || key == "gateway.ordered" ||
           key == "gateway.imports" || key.find(".import_") != std::string::npos;
  });
  return all;
}

}  // namespace arkmesh::gateway
