#include "cli/bus_options.hpp"

#include <CLI/CLI.hpp>

#include "hal/config.hpp"

namespace arkmesh::cli {

void BusOptions::add_to(CLI::App& command) {
  command.add_option("file", file, "The lab's configuration file; without it the lab on the default bus.url")
      ->check(CLI::ExistingFile);
  command.add_option("--set", sets, "Override a key of the file, as for `arkmesh lab`")->allow_extra_args(false);
}

hal::BusConfig BusOptions::bus() const {
  if (file.empty()) return {};
  return hal::Config::from_file(file, sets).root().section("bus").read<hal::BusConfig>();
}

std::string BusOptions::lab() const {
  if (file.empty()) return {};
  return hal::Config::from_file(file, sets).root().section("lab").get("name", std::string(), {.required = true});
}

}  // namespace arkmesh::cli
