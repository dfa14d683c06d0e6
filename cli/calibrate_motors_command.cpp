// `arkmesh calibrate-motors`: duties at which each robot on the table turns and goes straight as it should.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "cli/status_line.hpp"
#include "hal/platforms/kilobot/robot_ids.hpp"
#include "testbed/chore_table.hpp"
#include "tracker/identity/identity_keeper.hpp"
#include "tracker/identity/motor_calibrator.hpp"

namespace arkmesh::cli {
namespace {

constexpr std::size_t most_robots = 256;

struct CalibrateOptions {
  testbed::ChoreOptions table{.program = "calibrate_motors.c"};
  std::string ids;
  int first_duty = 60;
  double most_s = 900;
};

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
  std::sort(frame.robots.begin(), frame.robots.end(), [](const auto& a, const auto& b) { return a.robot < b.robot; });
  return frame;
}

std::string stages(const tracker::MotorCalibrator& calibrator) {
  std::map<tracker::MotorCalibrator::Stage, int> count;
  for (const auto& [id, robot] : calibrator.robots()) ++count[robot.stage];
  std::string out;
  for (const auto& [stage, robots] : count)
    out += fmt::format("{}{} {}", out.empty() ? "" : ", ", robots, name_of(stage));
  return out;
}

int calibrate(const CalibrateOptions& options) {
  using tracker::MotorCalibrator;
  std::vector<hal::RobotId> ids;
  if (!options.ids.empty()) ids = testbed::parse_ids(options.ids, 1022, "--ids");
  testbed::ChoreTable table(options.table);
  if (ids.empty()) ids = table.info().robots;
  std::sort(ids.begin(), ids.end());
  if (ids.size() > most_robots)
    throw CLI::ValidationError("--ids", fmt::format("{} robots are too many at once; calibrate at most {} at a time",
                                                    ids.size(), most_robots));
  if (!table.is_simulated())
    fmt::print(stderr,
               "The robots must run kilolib/programs/calibrate_motors.c: load it with `arkmesh ohc PORT upload "
               "calibrate_motors.hex`.\n");

  table.robots().command({.kind = hal::FleetCommand::Kind::run});
  for (int i = 0; i < 10; ++i) table.next_picture({});
  tracker::IdentityKeeper keeper({.expected = ids});
  std::vector<hal::RobotId> present;
  std::optional<MotorCalibrator> calibrator;
  {
    StatusLine status("calibrate-motors");
    const double end_s = options.most_s + 300;
    while (!(calibrator && calibrator->finished()) && table.seconds() < end_s && !operator_stops()) {
      // a robot in doubt comes first
      const auto question = keeper.question();
      const auto seen = table.next_picture(question || !calibrator ? question : calibrator->question());
      keeper.on_frame(table.now(), seen);
      for (const tracker::Naming& naming : keeper.take_namings()) table.name(naming.track, naming.robot);
      table.withhold(keeper.doubtful());
      if (!calibrator) {
        const auto progress = keeper.progress();
        status.show(fmt::format("{:.1f} s, {} of {} robots named", table.seconds(), progress.named, ids.size()));
        if (!keeper.settled(3)) continue;
        std::ranges::set_difference(ids, keeper.doubtful(), std::back_inserter(present));
        if (present.empty()) break;
        calibrator.emplace(tracker::MotorSettings{.width_m = table.info().width_m,
                                                  .height_m = table.info().height_m,
                                                  .first_duty = options.first_duty,
                                                  .most_per_robot_s = options.most_s},
                           present);
      }
      calibrator->on_frame(named(table.now(), seen, keeper));
      table.robots().offer(calibrator->take_messages());
      status.show(fmt::format("{:.0f} s, {}{}", table.seconds(), stages(*calibrator),
                              calibrator->storing() ? ", storing" : ""));
    }
  }

  std::vector<hal::RobotId> missing;
  std::ranges::set_difference(ids, present, std::back_inserter(missing));
  std::size_t good = 0;
  if (calibrator) {
    constexpr double degrees = 180 / std::numbers::pi;
    fmt::print("{:>6} {:>5} {:>6} {:>11} {:>12}  {:>9} {:>9} {:>6} {:>11} {}\n", "robot", "left", "right", "straight_l",
               "straight_r", "left_dps", "right_dps", "mm_s", "bend_dps", " result");
    for (const auto& [id, robot] : calibrator->robots()) {
      const bool done = robot.stage == MotorCalibrator::Stage::done;
      good += done && robot.stored;
      fmt::print("{:>6} {:>5} {:>6} {:>11} {:>12}  {:>9.1f} {:>9.1f} {:>6.1f} {:>11.1f}  {}\n", id,
                 robot.duties.turn_left, robot.duties.turn_right, robot.duties.straight_left,
                 robot.duties.straight_right, robot.turn_left_rad_s * degrees, robot.turn_right_rad_s * degrees,
                 robot.straight_m_s * 1000, robot.straight_turn_rad_s * degrees,
                 !done          ? fmt::format("failed: {}", robot.why.empty() ? "time is over" : robot.why)
                 : robot.stored ? "stored"
                                : "not confirmed that it is stored");
    }
  }
  if (!missing.empty()) fmt::print("not found: {}\n", hal::kilobot::in_words(missing));
  fmt::print("{} of {} robots calibrated and stored, after {:.0f} s\n", good, ids.size(), table.seconds());
  return good == ids.size() ? 0 : 1;
}

}  // namespace

void add_calibrate_motors_command(CLI::App& app) {
  const auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = add_command(app, "calibrate-motors");
  command->add_option("file", options->table.file, "The lab's configuration file")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--set", options->table.sets, "Override a key: --set arena.use=kilobot")->allow_extra_args(false);
  command->add_option("--ids", options->ids, "Which robots, such as 0-11,40 (default: the lab's robots)");
  command->add_option("--duty", options->first_duty, "To begin with, of 255")
      ->check(CLI::Range(40, 110))
      ->capture_default_str();
  command->add_option("--seconds", options->most_s, "Give a robot up after this time")
      ->check(CLI::Range(10.0, 1e5))
      ->capture_default_str();
  command->footer(
      "Examples:\n  arkmesh calibrate-motors lab.toml\n  arkmesh calibrate-motors lab.toml --ids 3,7 --duty 65\n"
      "Each robot needs an id of its own and about 15 cm of room. Real robots must run "
      "kilolib/programs/calibrate_motors.c; simulated ones do\n"
      "so by themselves. Ends with 1 when a robot was not calibrated.");
  command->callback([options] {
    if (const int code = calibrate(*options)) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
