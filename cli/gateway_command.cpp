// `arkmesh gateway`: joins a lab's LCM bus with other labs.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "gateway/gateway_process.hpp"

namespace arkmesh::cli {
namespace {

struct Options {
  std::string file;
  std::vector<std::string> sets;
};

}  // namespace

void add_gateway_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = add_command(app, "gateway");
  command->add_option("file", options->file, "The lab's configuration file, the same as for `arkmesh lab`")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--set", options->sets, "Override a key: --set gateway.listen=127.0.0.1:7901")
      ->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh lab experiments/dhtf/shark.toml &\n  arkmesh gateway experiments/dhtf/shark.toml\n"
      "SIGINT or SIGTERM ends it, SIGHUP makes it read its rules again (arkmesh reload).");
  command->callback(
      [options] { gateway::run_gateway([options] { return hal::Config::from_file(options->file, options->sets); }); });
}

}  // namespace arkmesh::cli
