// `arkmesh explain`: which rule lets a channel pass between two labs, or why none does.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "gateway/lab_rules.hpp"

namespace arkmesh::cli {
namespace {

struct ExplainOptions {
  std::string channel, to, from;
  std::vector<std::string> files;
};

bool explain_channel(const ExplainOptions& options) {
  if (options.to.empty() == options.from.empty()) throw hal::ConfigError("explain: give either --to LAB or --from LAB");
  const bool out = options.from.empty();
  const std::string& named = out ? options.to : options.from;
  // What came from a lab is called LAB/CHANNEL here.
  std::string channel = options.channel;
  if (!out && channel.starts_with(named + "/")) channel.erase(0, named.size() + 1);

  const std::vector<gateway::LabRules> labs(options.files.begin(), options.files.end());
  const auto of_named = std::ranges::find(labs, named, &gateway::LabRules::lab);
  const gateway::LabRules* const its = of_named == labs.end() ? nullptr : &*of_named;
  if (std::ranges::all_of(labs, [&](const gateway::LabRules& each) { return each.lab == named; }))
    throw hal::ConfigError(fmt::format("{} is lab {}'s own file; give the file of the lab that {} it",
                                       options.files.front(), named, out ? "sends to" : "receives from"));
  bool passes = true;
  for (const gateway::LabRules& other : labs) {
    if (other.lab == named) continue;
    const gateway::Explanation way = out ? gateway::explain_way(channel, other.lab, &other, named, its)
                                         : gateway::explain_way(channel, named, its, other.lab, &other);
    fmt::print("{}", way.text);
    passes &= way.passes;
  }
  return passes;
}

}  // namespace

void add_explain_command(CLI::App* command) {
  const auto options = std::make_shared<ExplainOptions>();
  command->add_option("channel", options->channel, "The channel, by its name in its own lab")->required();
  command->add_option("file", options->files, "The file of one lab, or of both, which explains the whole path")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--to", options->to, "Receiving lab");
  command->add_option("--from", options->from, "Sending lab");
  command->footer(
      "Examples:\n  arkmesh explain world --to roark experiments/dhtf/shark.toml\n"
      "  arkmesh explain roark/world --from roark experiments/dhtf/shark.toml\n"
      "  arkmesh explain poses --to roark experiments/dhtf/shark.toml experiments/dhtf/roark.toml\n"
      "Exit codes: 0 it passes, 1 it does not, 2 wrong command line or file.");
  command->callback([options] { end_with(explain_channel(*options) ? 0 : 1); });
}

}  // namespace arkmesh::cli
