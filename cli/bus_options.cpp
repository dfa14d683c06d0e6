#include "cli/bus_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "hal/config/config.hpp"
#include "hal/platforms/kilobot/port_lock.hpp"

namespace arkmesh::cli {

void BusOptions::add_to(CLI::App& command) {
  command.add_option("file", file, "The lab's configuration file (default: the lab on the default bus.url)")
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

std::string BusOptions::hung_words() const {
  if (file.empty()) return {};
  const hal::Section arena = hal::Config::from_file(file, sets).root().section("arena");
  if (arena.get("use", std::string()) != "kilobot") return {};
  const auto holder = hal::kilobot::port_holder(arena.section("kilobot").get("port", std::string()));
  if (!holder || holder->state != hal::kilobot::PortHolder::State::hung) return {};
  return fmt::format(
      "{0} (process {1}) hangs; its guard is stopping the robots; to make sure that they stop, end the process: kill "
      "-9 {1}",
      holder->who, holder->process);
}

}  // namespace arkmesh::cli
