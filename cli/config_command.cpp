// `arkmesh config`: what a configuration may hold.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "app/config_keys.hpp"
#include "cli/commands.hpp"

namespace arkmesh::cli {

void add_config_command(CLI::App* command) {
  const auto section = std::make_shared<std::string>();
  const auto wants_sample = std::make_shared<bool>(false);
  CLI::Option* const keys =
      command
          ->add_option("--keys", *section, "Every key with type, unit, default and range; of one section: --keys gate")
          ->expected(0, 1);
  command->add_flag("--sample", *wants_sample, "A commented file that runs as it is")->excludes(keys);
  command->footer("Example:\n  arkmesh config --sample > lab.toml; arkmesh run lab.toml");
  command->callback([section, wants_sample, keys] {
    if (keys->count() == 0 && !*wants_sample) throw hal::ConfigError("config: give --keys or --sample");
    std::vector<hal::KeyRow> rows = app::all_keys();
    std::erase_if(rows, [&](const hal::KeyRow& row) {
      return !(row.table + ".").starts_with(*section + (section->empty() ? "" : "."));
    });
    if (rows.empty()) throw hal::ConfigError(fmt::format("--keys {}: there is no such section", *section));
    fmt::print("{}", *wants_sample ? hal::print_sample(rows) : hal::print_keys(rows));
  });
}

}  // namespace arkmesh::cli
