#include "cli/set_up_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <stdexcept>

#include "app/set_up.hpp"
#include "hal/config.hpp"

namespace arkmesh::cli {

void SetUpOptions::add_to(CLI::App& command) {
  command.add_option("file", file, "The lab's configuration file")->required()->check(CLI::ExistingFile);
  command.add_option("--set", sets, "Override a key: --set arena.use=kilobot")->allow_extra_args(false);
  command.add_option("--record", record,
                     "At a testbed: keep serial bytes and pictures in this new folder, for `arkmesh testbed replay`");
}

testbed::SetUpArena SetUpOptions::open_arena(hal::StopRequest& stop) const {
  std::vector<std::string> all = sets;
  if (!record.empty()) all.push_back("arena.kilobot.record=" + hal::to_toml(record));
  return app::make_set_up_arena(file, all, program.empty() ? "" : program + ".c", stop);
}

std::vector<hal::RobotId> SetUpOptions::listed_ids(hal::RobotId largest) const {
  if (ids.empty()) return {};
  try {
    return testbed::parse_ids(ids, largest);
  } catch (const std::invalid_argument& wrong) {
    throw CLI::ValidationError("--ids", wrong.what());
  }
}

void SetUpOptions::say_program(const testbed::SetUpArena& arena) const {
  if (!arena.is_simulated())
    fmt::print(stderr, "The robots must run firmware/{0}.c: load it with `arkmesh ohc PORT upload {0}.hex`.\n",
               program);
}

void SetUpOptions::say_whose_robots(bool simulated) {
  if (simulated) fmt::print(stderr, "The robots are simulated: the result does not apply to real ones.\n");
}

}  // namespace arkmesh::cli
