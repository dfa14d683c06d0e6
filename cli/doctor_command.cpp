// `arkmesh doctor`: says in plain words what on this machine would keep a lab from working, and the command that mends
// it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "app/doctor/device_files.hpp"
#include "app/doctor/doctor.hpp"
#include "cli/commands.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::cli {
namespace {

// Returns how many of them are problems.
int say(const std::vector<hal::Finding>& findings) {
  int problems = 0;
  for (const hal::Finding& finding : findings) {
    if (finding.problem.empty()) {
      fmt::print("ok       {}\n", finding.what);
    } else {
      ++problems;
      fmt::print("problem  {}: {} -> {}\n", finding.what, finding.problem, finding.remedy);
    }
  }
  std::fflush(stdout);
  return problems;
}

}  // namespace

void add_doctor_command(CLI::App* command, std::vector<hal::Finding> (*examine_testbed)(const hal::Section& arena)) {
  const auto file = std::make_shared<std::string>();
  command->add_option("LABFILE", *file,
                      "Also check this lab's LCM and TCP ports, and the cameras and controller of a real testbed");
  const auto sets = std::make_shared<std::vector<std::string>>();
  command->add_option("--set", *sets, "Override a key of that file: --set arena.use=kilobot")->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh doctor experiments/dhtf/shark.toml\nExit code 0 if there is no problem, else 1.");
  command->callback([file, sets, examine_testbed] {
    if (!file->empty()) hand_over_cameras({*file}, *sets);
    const hal::Finding route = app::multicast();
    int problems = say({route});
    problems += say(app::machine());
    problems += say(app::serial_ports());
    problems += say(app::cameras());
    if (!file->empty()) {
      const hal::Config config = hal::Config::from_file(*file, *sets);
      problems += say(app::lab_ports(config.root(), route.problem.empty()));
      const hal::Section arena = config.root().section("arena");
      const std::string use = arena.get("use", std::string("ode"));
      if (examine_testbed && (use == "kilobot" || use == "aseba")) problems += say(examine_testbed(arena));
    }
    fmt::print("{}\n", problems == 0   ? "No problems found."
                       : problems == 1 ? "1 problem."
                                       : fmt::format("{} problems.", problems));
    end_with(problems == 0 ? 0 : 1);
  });
}

}  // namespace arkmesh::cli
