#include "testbed/record_walks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>

#include "tracker/identity/identity_keeper.hpp"

namespace arkmesh::testbed {
namespace {

constexpr double naming_within_s = 300;

}  // namespace

WalkReport record_walks(SetUpArena& arena, const WalkSettings& settings, std::ostream& table, hal::StopRequest& stop,
                        hal::Progress& progress) {
  arena.run();
  tracker::IdentityKeeper keeper({.expected = settings.ids});
  WalkReport report{.simulated = arena.is_simulated()};
  std::set<hal::RobotId> written;
  std::optional<double> begun_s;
  table << fmt::format("# {} {} {}\ntime_s,robot,x_m,y_m,direction_rad,led\n", arena.info().width_m,
                       arena.info().height_m, arena.tracks() ? "led" : "body");
  const auto goes_on = [&] {
    const double now_s = arena.seconds();
    return !stop.stopped() && (begun_s ? now_s - *begun_s < settings.seconds : now_s < naming_within_s);
  };
  while (goes_on()) {
    const auto seen = arena.next_picture(keeper.question());
    keeper.on_frame(arena.now(), seen);
    for (const tracker::Naming& naming : keeper.take_namings()) arena.name(naming.track, naming.robot);
    arena.withhold(keeper.doubtful());
    if (!begun_s && keeper.settled(3)) begun_s = arena.seconds();
    progress.show(begun_s ? fmt::format("{:.0f} of {:.0f} s", arena.seconds() - *begun_s, settings.seconds)
                          : fmt::format("{} of {} robots named", keeper.progress().named, settings.ids.size()));
    for (const tracker::Track& track : seen) {
      const auto robot = keeper.robot_of(track.number);
      if (!begun_s || !robot || track.doubtful || track.age.count() > 0) continue;
      // a colour that answers a question tells nothing of what the robot does
      const bool tells = track.led_seen && !keeper.led_is_answer(track.number);
      table << fmt::format("{:.3f},{},{:.6f},{:.6f},{:.5f},{}\n", arena.seconds(), *robot, track.in_arena.x_m,
                           track.in_arena.y_m, track.led_direction_rad.value_or(std::nan("")),
                           tells ? static_cast<int>(track.led) : 0);
      written.insert(*robot);
      ++report.rows;
    }
  }
  progress.done();
  arena.robots().command({.kind = hal::FleetCommand::Kind::pause});
  arena.wait(hal::LabTime(1'000'000));
  std::ranges::set_difference(settings.ids, written, std::back_inserter(report.missing));
  return report;
}

}  // namespace arkmesh::testbed
