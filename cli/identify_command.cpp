// `arkmesh identify`: which robot in the arena is which.
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
#include "testbed/identify.hpp"

namespace arkmesh::cli {
namespace {

struct IdentifyOptions {
  SetUpOptions common;
  std::string protocol = "spelled";
  bool any = false;
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
    fmt::print("nameless: a robot at x {:.4f} m, y {:.4f} m\n", at.x_m, at.y_m);
  if (!report.missing.empty()) fmt::print("not found: {}\n", in_words(report.missing));
  if (!report.duplicates.empty())
    fmt::print("several robots have the same id: {}; give them ids of their own with `arkmesh assign-ids`\n",
               in_words(report.duplicates));
  if (!report.strangers.empty()) fmt::print("not expected, but there: {}\n", in_words(report.strangers));
  fmt::print("{} of {} robots named in {:.1f} s\n", report.named.size(), report.looked_for, report.took_s);
}

int identify(const IdentifyOptions& options) {
  using Protocol = testbed::IdentifySettings::Protocol;
  OperatorStop stop;
  testbed::SetUpArena arena = options.common.open_arena(stop);
  testbed::IdentifySettings settings{.protocol = options.protocol == "spelled" ? Protocol::spelled
                                                 : options.protocol == "ark"   ? Protocol::ark
                                                                               : Protocol::ark_runtime,
                                     .expected = options.common.listed_ids(arena.info().max_robot),
                                     .max_s = options.max_s};
  if (settings.expected.empty() && !options.any) settings.expected = arena.info().robots;
  std::ranges::sort(settings.expected);
  ProgressLine progress("identify");
  const testbed::IdentifyReport report = testbed::identify(arena, settings, stop, progress);
  SetUpOptions::say_whose_robots(report.simulated);
  print(report);
  return report.complete ? 0 : 1;
}

}  // namespace

void add_identify_command(CLI::App& app) {
  const auto options = std::make_shared<IdentifyOptions>();
  CLI::App* command = add_command(app, "identify");
  options->common.add_to(*command);
  command
      ->add_option("--protocol", options->protocol,
                   "spelled: programs with arkmesh_id.h, all robots at once; ark, ark-runtime: ARK's message 120 or "
                   "119, one by one")
      ->check(CLI::IsMember({"spelled", "ark", "ark-runtime"}))
      ->capture_default_str();
  command->add_option("--ids", options->common.ids,
                      "Which robots to expect, such as 0-11,40 (default: the lab's robots)");
  command->add_flag("--any", options->any, "Expect no particular robots: accept all that answer")->excludes("--ids");
  command
      ->add_option("--seconds", options->max_s,
                   "Give up after this time (default: 120, with ARK's messages 3 for each id)")
      ->check(CLI::Range(1.0, 1e5));
  command->footer(
      "Examples:\n  arkmesh identify lab.toml\n  arkmesh identify lab.toml --any\n  arkmesh identify lab.toml "
      "--protocol ark --ids 0-19\n"
      "Robots need not run their program. Ends with 1 when an expected robot was not found.");
  command->callback([options] {
    if (const int code = identify(*options)) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
