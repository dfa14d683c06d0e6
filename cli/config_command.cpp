// `arkmesh config`: what a configuration may hold.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "app/airtime_trial.hpp"
#include "app/config_keys.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/progress_line.hpp"
#include "hal/counted.hpp"
#include "scenarios/python/python_scenario.hpp"

namespace arkmesh::cli {
namespace {

void print(const app::AirtimeNeed& need) {
  const double room = need.room, robots = static_cast<double>(need.robots);
  fmt::print("{}: {}, layout {}; room for {:.1f} words a second, so {:.2f} s for a word to each robot\n", need.lab,
             hal::counted(need.robots, "robot"), need.layout, room, robots / room);
  if (need.slots.empty()) return fmt::print("sends nothing to individual robots\n");
  fmt::print("  {:>4}  {:>8}  {:>15}  {:>19}\n", "slot", "words/s", "share of airtime", "in busiest second");
  const auto line = [&](const std::string& slot, const app::SlotNeed& slot_need) {
    const double each_s = static_cast<double>(slot_need.words) / need.seconds;
    fmt::print("  {:>4}  {:>8.1f}  {:>14.1f} %  {:>19}\n", slot, each_s, 100 * each_s / room, slot_need.in_one_s);
  };
  for (const auto& [slot, slot_need] : need.slots) line(fmt::format("{}", slot), slot_need);
  if (need.slots.size() > 1) line("all", need.all);
  if (need.anew > 0)
    fmt::print("  to resend everything after a reset or a lost connection: {} words, {:.1f} s\n", need.anew,
               static_cast<double>(need.anew) / room);
  const auto share = [&](std::uint64_t messages) {
    return 100 * static_cast<double>(messages) / static_cast<double>(need.air.offered);
  };
  if (need.air.replaced > 0)
    fmt::print("  {:.1f} % were replaced by newer ones before they were sent\n", share(need.air.replaced));
  if (need.air.refused > 0)
    fmt::print("  {:.1f} % were refused: the layout cannot carry them, or no robot has that id\n",
               share(need.air.refused));
}

void print_airtime(const std::vector<std::string>& files, const std::vector<std::string>& sets, double seconds) {
  OperatorStop stop;
  ProgressLine progress("trial");
  const std::vector<app::AirtimeNeed> needs = app::try_airtime({files, sets}, seconds, stop, &progress);
  progress.done();
  fmt::print("in {} s of simulation; a whole message counts as 3 words\n", seconds);
  for (const app::AirtimeNeed& need : needs) print(need);
}

}  // namespace

void add_config_command(CLI::App* command) {
  const auto section = std::make_shared<std::string>();
  const auto wants_sample = std::make_shared<bool>(false);
  CLI::Option* const keys = command
                                ->add_option("--keys", *section,
                                             "List all keys with type, unit, default and range; those of a section: "
                                             "--keys gate; of a Python scenario: --keys light_up.py")
                                ->expected(0, 1);
  command->add_flag("--sample", *wants_sample, "Print a commented file that runs unchanged")->excludes(keys);
  const auto airtime = std::make_shared<std::vector<std::string>>(),
             sets = std::make_shared<std::vector<std::string>>();
  const auto seconds = std::make_shared<double>(60);
  CLI::Option* const trial =
      command
          ->add_option("--airtime", *airtime,
                       "Simulate the labs, and compare their messages to robots, by slot, with the available airtime")
          ->check(CLI::ExistingFile)
          ->excludes(keys);
  command->add_option("--seconds", *seconds, "Lab time to simulate (default 60)")
      ->check(CLI::PositiveNumber)
      ->needs(trial);
  command->add_option("--set", *sets, "Override a key for the trial: --set arena.robots=100")
      ->allow_extra_args(false)
      ->needs(trial);
  command->footer(
      "Examples:\n  arkmesh config --sample > lab.toml; arkmesh run lab.toml\n"
      "  arkmesh config --airtime shark.toml roark.toml --set arena.robots=100");
  command->callback([section, wants_sample, keys, airtime, sets, seconds] {
    if (!airtime->empty()) return print_airtime(*airtime, *sets, *seconds);
    if (keys->count() == 0 && !*wants_sample) throw hal::ConfigError("config: give --keys, --sample or --airtime");
    if (scenarios::python::is_python(*section)) {
      const std::vector<hal::KeyRow> rows = scenarios::python::settings_of(*section);
      return fmt::print("{}", rows.empty() ? fmt::format("{} has no settings\n", *section) : hal::print_keys(rows));
    }
    std::vector<hal::KeyRow> rows = app::all_keys();
    std::erase_if(rows, [&](const hal::KeyRow& row) {
      return !(row.table + ".").starts_with(*section + (section->empty() ? "" : "."));
    });
    if (rows.empty()) throw hal::ConfigError(fmt::format("--keys {}: unknown section", *section));
    fmt::print("{}", *wants_sample ? hal::print_sample(rows) : hal::print_keys(rows));
  });
}

}  // namespace arkmesh::cli
