// `arkmesh assign-ids`: gives each robot in the arena an id of its own.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <string>

#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "cli/progress_line.hpp"
#include "cli/set_up_options.hpp"
#include "testbed/assign_ids.hpp"

namespace arkmesh::cli {
namespace {

struct AssignOptions {
  SetUpOptions common{.program = "assign_ids"};
  double max_s = 0;
};

int assign(const AssignOptions& options) {
  OperatorStop stop;
  testbed::AssignIdsSettings settings{.ids = options.common.listed_ids(1022), .max_s = options.max_s};
  testbed::SetUpArena arena = options.common.open_arena(stop);
  if (settings.ids.empty()) settings.ids = arena.info().robots;
  options.common.say_program(arena);
  // The clock only tells calls apart, nothing follows from it.
  settings.session =
      static_cast<std::uint8_t>(std::chrono::system_clock::now().time_since_epoch() / std::chrono::seconds(1));
  ProgressLine progress("assign-ids");
  const testbed::AssignIdsReport report = testbed::assign_ids(arena, settings, stop, progress);

  SetUpOptions::say_whose_robots(report.simulated);
  if (!report.robots.empty()) fmt::print("{:>6} {:>9} {:>9}  {}\n", "robot", "x_m", "y_m", "result");
  for (const tracker::IdAssigner::Robot& robot : report.robots)
    fmt::print("{:>6} {:>9.4f} {:>9.4f}  {}\n", robot.given ? std::to_string(*robot.given) : "-", robot.in_arena.x_m,
               robot.in_arena.y_m, name_of(robot.outcome));
  fmt::print("{} of {} robots have ids of their own, after {:.1f} s\n", report.confirmed, report.robots.size(),
             report.took_s);
  if (!report.finished) fmt::print(stderr, "arkmesh: stopped before the end\n");
  return report.finished && report.confirmed == report.robots.size() && report.confirmed > 0 ? 0 : 1;
}

}  // namespace

void add_assign_ids_command(CLI::App& app) {
  const auto options = std::make_shared<AssignOptions>();
  CLI::App* command = add_command(app, "assign-ids");
  options->common.add_to(*command);
  command->add_option("--ids", options->common.ids,
                      "Ids to give, such as 0-11,40, in rows from north to south (default: the lab's robots)");
  command
      ->add_option("--seconds", options->max_s, "Give up after this time (default: 180, and half a second for each id)")
      ->check(CLI::Range(1.0, 1e5));
  command->footer(
      "Examples:\n  arkmesh assign-ids lab.toml\n  arkmesh assign-ids lab.toml --ids 100-149\n"
      "Real robots must run firmware/assign_ids.c; simulated ones run it already. Ends with 1 when a "
      "robot got no id.");
  command->callback([options] {
    if (const int code = assign(*options)) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
