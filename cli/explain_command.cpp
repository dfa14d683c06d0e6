// `arkmesh explain`: which rule lets a channel pass between two labs, or why none does.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "gateway/config.hpp"
#include "gateway/explanation.hpp"
#include "hal/participants.hpp"

namespace arkmesh::cli {
namespace {

using gateway::Direction;

struct ExplainOptions {
  std::string channel, to, from;
  std::vector<std::string> files;
};

// A lab's file, as far as it is about its gateway.
struct LabFile {
  std::string file, lab;
  gateway::GatewayConfig config;

  explicit LabFile(const std::string& path) : file(path) {
    const hal::Config read = hal::Config::from_file(path);
    const hal::Section root = read.root();
    const auto shared = root.read<hal::Participants>();
    lab = shared.lab;
    config = gateway::read_gateway_config(root.section("gateway"), lab, shared.labs);
    read.refuse_unknown("gateway");
  }

  gateway::Explanation explain(Direction way, const std::string& channel, const std::string& peer) const {
    std::vector<std::string> peers = config.ignored;
    for (const gateway::PeerConfig& each : config.peers) peers.push_back(each.lab);
    if (std::ranges::find(peers, peer) == peers.end())
      throw hal::ConfigError(fmt::format("{}: lab {} has no peer {}; gateway.peers names {}", file, lab, peer,
                                         peers.empty() ? "nobody" : fmt::format("{}", fmt::join(peers, ", "))));
    if (std::ranges::find(config.ignored, peer) != config.ignored.end())
      return {.text = fmt::format("lab {} takes no part: it is not in shared.labs of {}\n", peer, file)};
    return gateway::explain({lab, file, config.rules}, way, channel, peer);
  }
};

// From the sender's side to the receiver's, as far as their files are given. Returns whether it passes.
bool explain_way(const std::string& channel, const std::string& sender, const LabFile* from,
                 const std::string& receiver, const LabFile* to) {
  std::string name = channel;
  if (from) {
    const gateway::Explanation there = from->explain(Direction::exports, name, receiver);
    fmt::print("{}", there.text);
    if (!there.passes) return false;
    name = there.channel;
    if (!to)
      fmt::print("Whether lab {} takes it, its file says: arkmesh explain {} --from {} FILE\n", receiver, name, sender);
  }
  if (!to) return true;
  const gateway::Explanation here = to->explain(Direction::imports, name, sender);
  fmt::print("{}", here.text);
  return here.passes;
}

bool explain_channel(const ExplainOptions& options) {
  if (options.to.empty() == options.from.empty())
    throw hal::ConfigError("explain: give --to LAB or --from LAB, one of them");
  const bool out = options.from.empty();
  const std::string& named = out ? options.to : options.from;
  // What came from a lab is called LAB/CHANNEL here.
  std::string channel = options.channel;
  if (!out && channel.starts_with(named + "/")) channel.erase(0, named.size() + 1);

  std::optional<LabFile> of_named;
  std::vector<LabFile> others;
  for (const std::string& file : options.files) {
    LabFile read(file);
    if (read.lab == named)
      of_named.emplace(std::move(read));
    else
      others.push_back(std::move(read));
  }
  if (others.empty())
    throw hal::ConfigError(fmt::format("{} is the file of lab {} itself; give that of the lab that {} it",
                                       options.files.front(), named, out ? "sends to" : "receives from"));
  const LabFile* const its = of_named ? &*of_named : nullptr;
  bool passes = true;
  for (const LabFile& other : others)
    passes &=
        out ? explain_way(channel, other.lab, &other, named, its) : explain_way(channel, named, its, other.lab, &other);
  return passes;
}

}  // namespace

void add_explain_command(CLI::App& app) {
  CLI::App* command = add_command(app, "explain");
  const auto options = std::make_shared<ExplainOptions>();
  command->add_option("channel", options->channel, "The channel, as its own lab calls it")->required();
  command->add_option("file", options->files, "Files of labs; with those of both labs the whole way is explained")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--to", options->to, "The lab that is to get it");
  command->add_option("--from", options->from, "The lab that it comes from");
  command->footer(
      "Examples:\n  arkmesh explain world --to roark experiments/dhtf/shark.toml\n"
      "  arkmesh explain roark/world --from roark experiments/dhtf/shark.toml\n"
      "  arkmesh explain poses --to roark experiments/dhtf/shark.toml experiments/dhtf/roark.toml\n"
      "Exit codes: 0 it passes, 1 it does not, 2 wrong command line or file.");
  command->callback([options] {
    if (!explain_channel(*options)) throw CLI::RuntimeError(1);
  });
}

}  // namespace arkmesh::cli
