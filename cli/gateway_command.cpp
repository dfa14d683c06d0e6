// `arkmesh gateway`: joins a lab's LCM bus with other labs.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "gateway/gateway_process.hpp"

namespace arkmesh::cli {
void add_gateway_command(CLI::App* command) {
  const auto file = std::make_shared<std::string>();
  const auto sets = std::make_shared<std::vector<std::string>>();
  command->add_option("file", *file, "The lab's configuration file, the same as for `arkmesh lab`")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--set", *sets, "Override a key: --set gateway.listen=127.0.0.1:7901")->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh lab experiments/dhtf/shark.toml &\n  arkmesh gateway experiments/dhtf/shark.toml\n"
      "SIGINT or SIGTERM ends it; SIGHUP reloads its rules (arkmesh reload).");
  command->callback([file, sets] { gateway::run_gateway([=] { return hal::Config::from_file(*file, *sets); }); });
}

}  // namespace arkmesh::cli
