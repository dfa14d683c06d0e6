// `arkmesh reload`: makes gateways that run read their rules again.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "gateway/reload_door.hpp"

namespace arkmesh::cli {
namespace {

void reload(const std::string& file) {
  const std::vector<std::string> answers = gateway::reload_gateways(file);
  if (answers.empty()) {
    gateway::check_gateway_file(hal::Config::from_file(file));
    throw std::runtime_error(
        fmt::format("none of your gateways runs with {}; start one with: arkmesh gateway {}", file, file));
  }
  for (const std::string& answer : answers) fmt::print("{}", answer);
}

}  // namespace

void add_reload_command(CLI::App* command) {
  const auto files = std::make_shared<std::vector<std::string>>();
  command->add_option("file", *files, "The configuration files with which the gateways were started")
      ->required()
      ->check(CLI::ExistingFile);
  command->footer(
      "Example:\n  arkmesh reload experiments/dhtf/shark.toml\n"
      "Changed keys that need a restart, such as addresses, are listed.\n"
      "Exit codes: 0 done, 1 no gateway runs with the file, 2 wrong command line or file.");
  command->callback([files] {
    for (const std::string& file : *files) reload(file);
  });
}

}  // namespace arkmesh::cli
