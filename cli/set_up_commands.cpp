// `arkmesh identify`, `assign-ids`, `calibrate-motors` and `fit robots`: procedures with the robots of an arena.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/testbed/set_up.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/progress_line.hpp"
#include "hal/arenas/robot_words.hpp"
#include "hal/config/config.hpp"
#include "hal/counted.hpp"
#include "hal/exit_code.hpp"
#include "testbed/assign_ids.hpp"
#include "testbed/calibrate_motors.hpp"
#include "testbed/camera_latency.hpp"
#include "testbed/identify.hpp"
#include "testbed/record_walks.hpp"
#include "testbed/set_up_arena.hpp"

namespace arkmesh::cli {
namespace {

struct SetUpOptions {
  std::string program;  // what robots must run, the name of one in firmware/; empty: their own
  std::string file, ids, record;
  std::vector<std::string> sets;

  void add_to(CLI::App* command, const std::string& ids_help) {
    command->add_option("file", file, "The lab's configuration file")->required()->check(CLI::ExistingFile);
    command->add_option("--set", sets, "Override a key: --set arena.use=kilobot")->allow_extra_args(false);
    command->add_option(
        "--record", record,
        "On a testbed: record serial bytes and pictures in this new folder, for `arkmesh testbed replay`");
    command->add_option("--ids", ids, ids_help + " (default: the lab's robots)");
  }

  // Waits until the arena is there.
  testbed::SetUpArena open_arena(hal::StopRequest& stop) const {
    std::vector<std::string> all = sets;
    if (!record.empty()) all.push_back("arena.kilobot.record=" + hal::to_toml(record));
    return app::make_set_up_arena(file, all, program.empty() ? "" : program + ".c", stop);
  }

  // Those of --ids, in that order. Throws CLI::ValidationError for an id above `largest` and for what is no list.
  std::vector<hal::RobotId> listed_ids(hal::RobotId largest) const try {
    return ids.empty() ? std::vector<hal::RobotId>() : testbed::parse_ids(ids, largest);
  } catch (const std::invalid_argument& wrong) {
    throw CLI::ValidationError("--ids", wrong.what());
  }

  // To people at an arena whose robots are real.
  void say_program(const testbed::SetUpArena& arena) const {
    if (!arena.is_simulated())
      fmt::print(stderr, "The robots must run firmware/{0}.c: load it with `arkmesh ohc PORT upload {0}.hex`.\n",
                 program);
  }
};

// To standard error, of a report: whether it is of simulated robots.
void say_whose_robots(bool simulated) {
  if (simulated) fmt::print(stderr, "The robots are simulated: the result does not apply to real ones.\n");
}

struct IdentifyOptions {
  SetUpOptions common;
  std::string protocol = "spelled";
  bool any = false, latency = false;
  double max_s = 0;  // 0: as long as it may take
};

void print(const testbed::IdentifyReport& report) {
  using hal::in_words;
  if (!report.named.empty())
    fmt::print("{:>6} {:>9} {:>9} {:>12} {:>10}\n", "robot", "x_m", "y_m", "heading_deg", "confidence");
  for (const auto& [robot, at, confidence] : report.named)
    fmt::print("{:>6} {:>9.4f} {:>9.4f} {:>12.1f} {:>10.2f}\n", robot, at.x_m, at.y_m,
               at.heading_rad * 180 / std::numbers::pi, confidence);
  for (const hal::Pose& at : report.nameless)
    fmt::print("unnamed: a robot at x {:.4f} m, y {:.4f} m\n", at.x_m, at.y_m);
  if (!report.missing.empty()) fmt::print("not found: {}\n", in_words(report.missing));
  if (!report.duplicates.empty())
    fmt::print("several robots have the same id: {}; give each its own with `arkmesh assign-ids`\n",
               in_words(report.duplicates));
  if (!report.strangers.empty()) fmt::print("unexpected: {}\n", in_words(report.strangers));
  fmt::print("{} of {} named in {:.1f} s\n", report.named.size(), hal::counted(report.looked_for, "robot"),
             report.took_s);
}

// Exit code 1: of a camera nothing is known.
int measure_latency(testbed::SetUpArena& arena, hal::StopRequest& stop) {
  constexpr int flashes = 64;
  ProgressLine progress("identify --latency");
  const std::vector<testbed::CameraLatency> cameras = testbed::measure_latency(arena, flashes, stop, progress);
  say_whose_robots(arena.is_simulated());
  bool all = !cameras.empty();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const testbed::CameraLatency& camera = cameras[i];
    const bool sure = 2 * camera.agree > camera.flashes && camera.latency_ms >= 0;
    all = all && sure;
    if (camera.flashes == 0)
      fmt::print("camera {} saw no robot flash: are robots switched on and in its view?\n", i);
    else if (!sure)
      fmt::print("camera {} has no steady latency: only {} of {} flashes agree with {:.1f} ms\n", i, camera.agree,
                 camera.flashes, camera.latency_ms);
    else
      fmt::print("camera {}: latency_ms = {:.1f} in [[arena.kilobot.cameras]], within {:.1f} ms ({} of {} flashes)\n",
                 i, camera.latency_ms, camera.within_ms, camera.agree, camera.flashes);
  }
  return all ? 0 : 1;
}

int identify(const IdentifyOptions& options) {
  using Protocol = testbed::IdentifySettings::Protocol;
  OperatorStop stop;
  testbed::SetUpArena arena = options.common.open_arena(stop);
  if (options.latency) return measure_latency(arena, stop);
  testbed::IdentifySettings settings{.protocol = options.protocol == "spelled" ? Protocol::spelled
                                                 : options.protocol == "ark"   ? Protocol::ark
                                                                               : Protocol::ark_runtime,
                                     .expected = options.common.listed_ids(arena.info().max_robot),
                                     .max_s = options.max_s};
  if (settings.expected.empty() && !options.any) settings.expected = arena.info().robots;
  std::ranges::sort(settings.expected);
  ProgressLine progress("identify");
  const testbed::IdentifyReport report = testbed::identify(arena, settings, stop, progress);
  say_whose_robots(report.simulated);
  print(report);
  return report.complete ? 0 : 1;
}

struct AssignOptions {
  SetUpOptions common{.program = "assign_ids"};
  double max_s = 0;
};

int assign(const AssignOptions& options) {
  OperatorStop stop;
  testbed::SetUpArena arena = options.common.open_arena(stop);
  testbed::AssignIdsSettings settings{.ids = options.common.listed_ids(arena.info().max_robot), .max_s = options.max_s};
  if (settings.ids.empty()) settings.ids = arena.info().robots;
  options.common.say_program(arena);
  // The clock only tells calls apart, nothing follows from it.
  settings.session =
      static_cast<std::uint8_t>(std::chrono::system_clock::now().time_since_epoch() / std::chrono::seconds(1));
  ProgressLine progress("assign-ids");
  const testbed::AssignIdsReport report = testbed::assign_ids(arena, settings, stop, progress);

  say_whose_robots(report.simulated);
  if (!report.robots.empty()) fmt::print("{:>6} {:>9} {:>9}  {}\n", "robot", "x_m", "y_m", "result");
  for (const tracker::IdAssigner::Robot& robot : report.robots)
    fmt::print("{:>6} {:>9.4f} {:>9.4f}  {}\n", robot.given ? std::to_string(*robot.given) : "-", robot.in_arena.x_m,
               robot.in_arena.y_m, name_of(robot.outcome));
  fmt::print("{} of {}, after {:.1f} s\n", report.confirmed,
             hal::counted(report.robots.size(), "robot has an id of its own", "robots have ids of their own"),
             report.took_s);
  if (!report.finished) fmt::print(stderr, "arkmesh: stopped before the end\n");
  return report.finished && report.confirmed == report.robots.size() && report.confirmed > 0 ? 0 : 1;
}

struct CalibrateMotorsOptions {
  SetUpOptions common{.program = "calibrate_motors"};
  int first_duty = 60;
  double max_s = 900;
};

std::string result(const tracker::MotorCalibrator::Robot& robot) {
  if (robot.stage != tracker::MotorCalibrator::Stage::done)
    return fmt::format("failed: {}", robot.why.empty() ? "time is up" : robot.why);
  return robot.stored ? "stored" : "storing not confirmed";
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
  fmt::print("{} of {} calibrated and stored, after {:.0f} s\n", report.stored, hal::counted(wanted, "robot"),
             report.took_s);
}

int calibrate(const CalibrateMotorsOptions& options) {
  OperatorStop stop;
  testbed::SetUpArena arena = options.common.open_arena(stop);
  testbed::CalibrateMotorsSettings settings{.ids = options.common.listed_ids(arena.info().max_robot),
                                            .first_duty = options.first_duty,
                                            .max_s = options.max_s};
  if (settings.ids.empty()) settings.ids = arena.info().robots;
  std::ranges::sort(settings.ids);
  if (settings.ids.size() > testbed::max_robots_to_calibrate)
    throw CLI::ValidationError("--ids", fmt::format("{} robots are too many at once; calibrate at most {} at a time",
                                                    settings.ids.size(), testbed::max_robots_to_calibrate));
  options.common.say_program(arena);
  ProgressLine progress("calibrate-motors");
  const testbed::CalibrateMotorsReport report = testbed::calibrate_motors(arena, settings, stop, progress);
  say_whose_robots(report.simulated);
  print(report, settings.ids.size());
  return report.stored == settings.ids.size() ? 0 : 1;
}

}  // namespace

void record_walks(const WalkOptions& options) {
  const SetUpOptions common{
      .program = "fit_robots", .file = options.file, .ids = options.ids, .record = {}, .sets = options.sets};
  OperatorStop stop;
  testbed::SetUpArena arena = common.open_arena(stop);
  testbed::WalkSettings settings{.ids = common.listed_ids(arena.info().max_robot), .seconds = options.seconds};
  if (settings.ids.empty()) settings.ids = arena.info().robots;
  std::ranges::sort(settings.ids);
  common.say_program(arena);
  ProgressLine progress("fit robots");
  std::ofstream table(options.table);
  const testbed::WalkReport report = testbed::record_walks(arena, settings, table, stop, progress);
  if (!table.flush()) throw std::runtime_error(options.table + " cannot be written; choose another place with --out");
  say_whose_robots(report.simulated);
  if (!report.missing.empty()) fmt::print(stderr, "not found: {}\n", hal::in_words(report.missing));
  if (report.rows == 0)
    throw hal::ExitError(hal::Exit::failed,
                         "no robot was identified; do they run firmware/fit_robots.c, with ids of their own?");
}

void add_identify_command(CLI::App* command) {
  const auto options = std::make_shared<IdentifyOptions>();
  options->common.add_to(command, "Which robots to expect, such as 0-11,40");
  command
      ->add_option("--protocol", options->protocol,
                   "spelled: programs with arkmesh_id.h, all robots at once; ark, ark-runtime: ARK's message 120 or "
                   "119, one by one")
      ->check(CLI::IsMember({"spelled", "ark", "ark-runtime"}))
      ->capture_default_str();
  command->add_flag("--any", options->any, "Accept all robots that answer, without a list of expected ids")
      ->excludes("--ids");
  command->add_flag("--latency", options->latency,
                    "Identify no robots; let all flash, and measure the cameras' latency (2 minutes)");
  command
      ->add_option("--seconds", options->max_s,
                   "Give up after this time (default: 120, with ARK's messages 3 for each id)")
      ->check(CLI::Range(1.0, 1e5));
  command->footer(
      "Examples:\n  arkmesh identify lab.toml\n  arkmesh identify lab.toml --any\n  arkmesh identify lab.toml "
      "--protocol ark --ids 0-19\n  arkmesh identify lab.toml --latency\n"
      "Robots need not run their program. Exit code 1 if an expected robot was not found.");
  command->callback([options] { end_with(identify(*options)); });
}

void add_assign_ids_command(CLI::App* command) {
  const auto options = std::make_shared<AssignOptions>();
  options->common.add_to(command, "Ids to give, such as 0-11,40, in rows from north to south");
  command
      ->add_option("--seconds", options->max_s, "Give up after this time (default: 180, and half a second for each id)")
      ->check(CLI::Range(1.0, 1e5));
  command->footer(
      "Examples:\n  arkmesh assign-ids lab.toml\n  arkmesh assign-ids lab.toml --ids 100-149\n"
      "Real robots must run firmware/assign_ids.c; simulated ones run it already. Exit code 1 if a robot got no id.");
  command->callback([options] { end_with(assign(*options)); });
}

void add_calibrate_motors_command(CLI::App* command) {
  const auto options = std::make_shared<CalibrateMotorsOptions>();
  options->common.add_to(command, "Which robots, such as 0-11,40");
  command->add_option("--duty", options->first_duty, "Motor duty of the first test, 0 to 255")
      ->check(CLI::Range(40, 110))
      ->capture_default_str();
  command->add_option("--seconds", options->max_s, "Give up on a robot after this time, in seconds")
      ->check(CLI::Range(10.0, 1e5))
      ->capture_default_str();
  command->footer(
      "Examples:\n  arkmesh calibrate-motors lab.toml\n  arkmesh calibrate-motors lab.toml --ids 3,7 --duty 65\n"
      "Each robot needs an id of its own and about 15 cm of free space. Real robots must run\n"
      "firmware/calibrate_motors.c; simulated ones run it already. Exit code 1\nif a robot was not calibrated.");
  command->callback([options] { end_with(calibrate(*options)); });
}

}  // namespace arkmesh::cli
