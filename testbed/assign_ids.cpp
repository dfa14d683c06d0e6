#include "testbed/assign_ids.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace arkmesh::testbed {

AssignIdsReport assign_ids(SetUpArena& arena, const AssignIdsSettings& settings, hal::StopRequest& stop,
                           hal::Progress& progress) {
  using tracker::IdAssigner;
  const double max_s = settings.max_s > 0 ? settings.max_s : 180 + 0.5 * static_cast<double>(settings.ids.size());
  arena.run();
  IdAssigner assigner({.ids = settings.ids, .session = settings.session});
  while (!assigner.finished() && arena.seconds() < max_s && !stop.stopped()) {
    const auto seen = arena.next_picture(assigner.question());
    assigner.on_frame(arena.now(), seen);
    const auto now = assigner.progress();
    progress.show(fmt::format("{:.1f} s, {}{}{}, {} of {} robots confirmed", arena.seconds(), name_of(assigner.phase()),
                              now.of ? fmt::format(" ({} of {})", now.done, now.of) : "",
                              now.round > 1 ? fmt::format(", round {}", now.round) : "", now.confirmed,
                              assigner.robots().size()));
  }
  progress.done();

  AssignIdsReport report{.finished = assigner.finished(), .took_s = arena.seconds(), .simulated = arena.is_simulated()};
  for (const auto& [number, robot] : assigner.robots()) {
    report.robots.push_back(robot);
    report.confirmed += robot.outcome == IdAssigner::Outcome::confirmed;
  }
  std::ranges::stable_sort(report.robots, {},
                           [](const IdAssigner::Robot& robot) { return robot.given.value_or(65536); });
  return report;
}

}  // namespace arkmesh::testbed
