// `arkmesh calibrate-motors`: duties at which each robot in the arena turns and goes straight as it should.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <numbers>
#include <string>

#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "cli/progress_line.hpp"
#include "cli/set_up_options.hpp"
#include "hal/robot_words.hpp"
#include "testbed/calibrate_motors.hpp"

namespace arkmesh::cli {
namespace {

struct CalibrateMotorsOptions {
  SetUpOptions common{.program = "calibrate_motors"};
  int first_duty = 60;
  double max_s = 900;
};

std::string result(const tracker::MotorCalibrator::Robot& robot) {
  if (robot.stage != tracker::MotorCalibrator::Stage::done)
    return fmt::format("failed: {}", robot.why.empty() ? "time is over" : robot.why);
  return robot.stored ? "stored" : "not confirmed that it is stored";
}

void print(const testbed::CalibrateMotorsReport& report, std::size_t wanted) {
  constexpr double degrees = 180 / std::numbers::pi;
  if (!report.robots.empty())
    fmt::print("{:>6} {:>5} {:>6} {:>11} {:>12}  {:>9} {:>9} {:>6} {:>11} {}\n", "robot", "left", "right", "straight_l",
               "straight_r", "left_dps", "right_dps", "mm_s", "bend_dps", " result");
  for (const auto& [id, robot] : report.robots)
    fmt::print("{:>6} {:>5} {:>6} {:>11} {:>12}  {:>9.1f} {:>9.1f} {:>6.1f} {:>11.1f}  {}\n", id,
               robot.duties.turn_left, robot.duties.turn_right, robot.duties.straight_left, robot.duties.straight_right,
               robot.turn_left_rad_s * degrees, robot.turn_right_rad_s * degrees, robot.straight_m_s * 1000,
               robot.straight_turn_rad_s * degrees, result(robot));
  if (!report.missing.empty()) fmt::print("not found: {}\n", hal::in_words(report.missing));
  fmt::print("{} of {} robots calibrated and stored, after {:.0f} s\n", report.stored, wanted, report.took_s);
}

int calibrate(const CalibrateMotorsOptions& options) {
  OperatorStop stop;
  testbed::CalibrateMotorsSettings settings{
      .ids = options.common.listed_ids(1022), .first_duty = options.first_duty, .max_s = options.max_s};
  testbed::SetUpArena arena = options.common.open_arena(stop);
  if (settings.ids.empty()) settings.ids = arena.info().robots;
  std::ranges::sort(settings.ids);
  if (settings.ids.size() > testbed::max_robots_to_calibrate)
    throw CLI::ValidationError("--ids", fmt::format("{} robots are too many at once; calibrate at most {} at a time",
                                                    settings.ids.size(), testbed::max_robots_to_calibrate));
  options.common.say_program(arena);
  ProgressLine progress("calibrate-motors");
  const testbed::CalibrateMotorsReport report = testbed::calibrate_motors(arena, settings, stop, progress);
  SetUpOptions::say_whose_robots(report.simulated);
  print(report, settings.ids.size());
  return report.stored == settings.ids.size() ? 0 : 1;
}

}  // namespace

void add_calibrate_motors_command(CLI::App& app) {
  const auto options = std::make_shared<CalibrateMotorsOptions>();
  CLI::App* command = add_command(app, "calibrate-motors");
  options->common.add_to(*command);
  command->add_option("--ids", options->common.ids, "Which robots, such as 0-11,40 (default: the lab's robots)");
  command->add_option("--duty", options->first_duty, "Duty of the first test, of 255")
      ->check(CLI::Range(40, 110))
      ->capture_default_str();
  command->add_option("--seconds", options->max_s, "Give up on a robot after this time, in seconds")
      ->check(CLI::Range(10.0, 1e5))
      ->capture_default_str();
  command->footer(
      "Examples:\n  arkmesh calibrate-motors lab.toml\n  arkmesh calibrate-motors lab.toml --ids 3,7 --duty 65\n"
      "Each robot needs an id of its own and about 15 cm of free space. Real robots must run\n"
      "firmware/calibrate_motors.c; simulated ones run it already. Ends with 1\n"
      "when a robot was not calibrated.");
  command->callback([options] {
    if (const int code = calibrate(*options)) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
