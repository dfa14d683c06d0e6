#include "testbed/calibrate_motors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>

#include "tracker/identity/identity_keeper.hpp"

namespace arkmesh::testbed {
namespace {

using tracker::MotorCalibrator;

constexpr double naming_takes_s = 300;  // at most, before the first robot moves

// What the calibrator may know: robots with a sure name.
hal::PoseFrame named(hal::LabTime now, std::span<const tracker::Track> tracks, const tracker::IdentityKeeper& keeper) {
  hal::PoseFrame frame{.stamp = now};
  for (const tracker::Track& track : tracks) {
    const auto robot = keeper.robot_of(track.number);
    if (robot && !track.doubtful && !keeper.led_is_answer(track.number))
      frame.robots.push_back({.robot = *robot,
                              .pose = track.in_arena,
                              .led = track.led_seen ? track.led : hal::Led::off,
                              .confidence = track.confidence,
                              .age = track.age});
  }
  std::ranges::sort(frame.robots, {}, &hal::Observation::robot);
  return frame;
}

std::string stages(const MotorCalibrator& calibrator) {
  std::map<MotorCalibrator::Stage, int> count;
  for (const auto& [id, robot] : calibrator.robots()) ++count[robot.stage];
  std::string out;
  for (const auto& [stage, robots] : count)
    out += fmt::format("{}{} {}", out.empty() ? "" : ", ", robots, name_of(stage));
  return out;
}

}  // namespace

CalibrateMotorsReport calibrate_motors(SetUpArena& arena, const CalibrateMotorsSettings& settings,
                                       hal::StopRequest& stop, hal::Progress& progress) {
  const std::vector<hal::RobotId>& ids = settings.ids;
  arena.run();
  tracker::IdentityKeeper keeper({.expected = ids});
  std::vector<hal::RobotId> present;
  std::optional<MotorCalibrator> calibrator;
  const double end_s = settings.max_s + naming_takes_s;
  while (!(calibrator && calibrator->finished()) && arena.seconds() < end_s && !stop.stopped()) {
    // a robot in doubt comes first
    const auto question = keeper.question();
    const auto seen = arena.next_picture(question || !calibrator ? question : calibrator->question());
    keeper.on_frame(arena.now(), seen);
    for (const tracker::Naming& naming : keeper.take_namings()) arena.name(naming.track, naming.robot);
    arena.withhold(keeper.doubtful());
    if (!calibrator) {
      progress.show(
          fmt::format("{:.1f} s, {} of {} robots named", arena.seconds(), keeper.progress().named, ids.size()));
      if (!keeper.settled(3)) continue;
      std::ranges::set_difference(ids, keeper.doubtful(), std::back_inserter(present));
      if (present.empty()) break;
      calibrator.emplace(tracker::MotorSettings{.width_m = arena.info().width_m,
                                                .height_m = arena.info().height_m,
                                                .body_radius_m = arena.info().body_radius_m,
                                                .first_duty = settings.first_duty,
                                                .max_per_robot_s = settings.max_s},
                         present);
    }
    calibrator->on_frame(named(arena.now(), seen, keeper));
    arena.robots().offer(calibrator->take_messages());
    progress.show(
        fmt::format("{:.0f} s, {}{}", arena.seconds(), stages(*calibrator), calibrator->storing() ? ", storing" : ""));
  }
  progress.done();

  CalibrateMotorsReport report{.took_s = arena.seconds(), .simulated = arena.is_simulated()};
  std::ranges::set_difference(ids, present, std::back_inserter(report.missing));
  if (calibrator) report.robots = calibrator->robots();
  report.stored = static_cast<std::size_t>(std::ranges::count_if(report.robots, [](const auto& each) {
    return each.second.stage == MotorCalibrator::Stage::done && each.second.stored;
  }));
  return report;
}

}  // namespace arkmesh::testbed
