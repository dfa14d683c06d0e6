// `arkmesh assign-ids`: gives each robot on the table an id of its own.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "cli/status_line.hpp"
#include "testbed/chore_table.hpp"
#include "tracker/identity/id_assigner.hpp"

namespace arkmesh::cli {
namespace {

struct AssignOptions {
  testbed::ChoreOptions table{.program = "assign_ids.c"};
  std::string ids;
  double most_s = 0;
};

int assign(const AssignOptions& options) {
  using tracker::IdAssigner;
  // before anything moves
  std::vector<hal::RobotId> ids;
  if (!options.ids.empty()) ids = testbed::parse_ids(options.ids, 1022, "--ids");
  testbed::ChoreTable table(options.table);
  if (ids.empty()) ids = table.info().robots;
  const double most_s = options.most_s > 0 ? options.most_s : 180 + 0.5 * static_cast<double>(ids.size());
  if (!table.is_simulated())
    fmt::print(
        stderr,
        "The robots must run kilolib/programs/assign_ids.c: load it with `arkmesh ohc PORT upload assign_ids.hex`.\n");

  table.robots().command({.kind = hal::FleetCommand::Kind::run});
  for (int i = 0; i < 10; ++i) table.next_picture({});
  // Robots draw once per session: another one for each call. The clock only tells calls apart, nothing follows from it.
  const auto session =
      static_cast<std::uint8_t>(std::chrono::system_clock::now().time_since_epoch() / std::chrono::seconds(1));
  IdAssigner assigner({.ids = ids, .session = session});
  {
    StatusLine status("assign-ids");
    while (!assigner.finished() && table.seconds() < most_s && !operator_stops()) {
      const auto seen = table.next_picture(assigner.question());
      assigner.on_frame(table.now(), seen);
      const auto progress = assigner.progress();
      status.show(fmt::format("{:.1f} s, {}{}{}, {} of {} robots confirmed", table.seconds(), name_of(assigner.phase()),
                              progress.of ? fmt::format(" ({} of {})", progress.done, progress.of) : "",
                              progress.round > 1 ? fmt::format(", round {}", progress.round) : "", progress.confirmed,
                              assigner.robots().size()));
    }
  }

  std::size_t confirmed = 0;
  if (!assigner.robots().empty()) fmt::print("{:>6} {:>9} {:>9}  {}\n", "robot", "x_m", "y_m", "result");
  std::vector<const IdAssigner::Robot*> rows;
  for (const auto& [number, robot] : assigner.robots()) rows.push_back(&robot);
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto* a, const auto* b) { return a->given.value_or(65536) < b->given.value_or(65536); });
  for (const IdAssigner::Robot* robot : rows) {
    confirmed += robot->outcome == IdAssigner::Outcome::confirmed;
    fmt::print("{:>6} {:>9.4f} {:>9.4f}  {}\n", robot->given ? std::to_string(*robot->given) : "-", robot->in_arena.x_m,
               robot->in_arena.y_m, name_of(robot->outcome));
  }
  fmt::print("{} of {} robots have ids of their own, after {:.1f} s\n", confirmed, rows.size(), table.seconds());
  if (!assigner.finished()) fmt::print(stderr, "arkmesh: stopped before the end\n");
  return assigner.finished() && confirmed == rows.size() && confirmed > 0 ? 0 : 1;
}

}  // namespace

void add_assign_ids_command(CLI::App& app) {
  const auto options = std::make_shared<AssignOptions>();
  CLI::App* command = add_command(app, "assign-ids");
  command->add_option("file", options->table.file, "The lab's configuration file")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--set", options->table.sets, "Override a key: --set arena.use=kilobot")->allow_extra_args(false);
  command->add_option("--ids", options->ids,
                      "Ids to give, such as 0-11,40, in rows from north to south (default: the lab's robots)");
  command
      ->add_option("--seconds", options->most_s,
                   "Give up after this time (default: 180, and half a second for each id)")
      ->check(CLI::Range(1.0, 1e5));
  command->footer(
      "Examples:\n  arkmesh assign-ids lab.toml\n  arkmesh assign-ids lab.toml --ids 100-149\n"
      "Real robots must run kilolib/programs/assign_ids.c; simulated ones do so by themselves. Ends with 1 when a "
      "robot got no id.");
  command->callback([options] {
    if (const int code = assign(*options)) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
