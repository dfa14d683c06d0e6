// `arkmesh testbed record` and `replay`: what happened at a testbed, kept and looked at again.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>

#include "app/arenas.hpp"
#include "app/testbed/testbed_replay.hpp"
#include "cli/commands.hpp"
#include "cli/lab_command.hpp"
#include "cli/operator_stop.hpp"
#include "emulator/said_words.hpp"
#include "hal/config/config.hpp"
#include "hal/counted.hpp"

namespace arkmesh::cli {
namespace {

struct TestbedOptions {
  LabOptions lab;
  double seconds = 0;
  std::string folder;
};

int record(const TestbedOptions& options) {
  LabOptions lab = options.lab;
  const auto raw = (std::filesystem::absolute(lab.out) / "raw").string();
  lab.sets.push_back("arena.kilobot.record=" + hal::to_toml(raw));
  if (options.seconds > 0) lab.sets.push_back("run.duration_s=" + hal::to_toml(options.seconds));
  const hal::Config config = hal::Config::from_file(lab.file, lab.sets);
  const hal::Section arena = config.root().section("arena");
  if (const std::string use = arena.get("use", std::string("ode")); use != "kilobot" && use != "emulated")
    arena.refuse("use", "has no devices to record; use \"kilobot\" or \"emulated\"");
  return run_lab(lab);
}

void say(const app::SaidWord& word, const hal::kilobot::WordLayout& layout) {
  fmt::print("{:>10.3f} {:>8.3f} {:>6} {:>6}  {}\n", static_cast<double>(word.first_us) * 1e-6,
             static_cast<double>(word.last_us - word.first_us) * 1e-6, word.copies, word.spoilt,
             emulator::in_words(word.message, layout));
}

int replay(const TestbedOptions& options) {
  OperatorStop stop;
  const app::TestbedRecord found = app::find_testbed_record(options.folder);
  fmt::print("{:>10} {:>8} {:>6} {:>6}  {}\n", "time_s", "for_s", "copies", "spoilt", "message");
  app::replay_words(found, stop, [&](const app::SaidWord& word) { say(word, found.layout); });
  std::fflush(stdout);
  const app::PoseComparison poses = app::compare_poses(found, stop);
  if (!poses.not_compared.empty()) {
    fmt::print("poses: {}\n", poses.not_compared);
    return 0;
  }
  fmt::print("poses: {} with {} of robots compared; {}; at most {:.4f} mm and {:.4f} degrees\n",
             hal::counted(poses.frames, "frame"), hal::counted(poses.poses, "pose"),
             hal::counted(poses.different, "frame differs", "frames differ"), 1000 * poses.most_m,
             poses.most_rad * 180 / std::numbers::pi);
  if (!poses.first_difference.empty()) fmt::print("poses: first in {}\n", poses.first_difference);
  if (!poses.ended_by.empty()) fmt::print("poses: comparison ended early: {}\n", poses.ended_by);
  return poses.same() ? 0 : 1;
}

}  // namespace

void add_testbed_command(CLI::App* testbed) {
  const auto options = std::make_shared<TestbedOptions>();
  testbed->require_subcommand(1);

  CLI::App* const keep = testbed->add_subcommand("record", "Run one lab, and record all traffic of its devices");
  keep->add_option("file", options->lab.file, "The lab's configuration file")->required()->check(CLI::ExistingFile);
  keep->add_option("--out", options->lab.out, "Folder for the results and, in raw/, the record; empty or new")
      ->required();
  keep->add_option("--seconds", options->seconds, "Duration of the run, in whole periods (overrides run.duration_s)")
      ->check(CLI::Range(0.1, 1e6));
  keep->add_flag("--open", options->lab.open, "Open the lab's page in a browser");
  keep->add_option("--set", options->lab.sets, "Override a key: --set arena.use=kilobot")->allow_extra_args(false);
  keep->callback([options] { end_with(record(*options)); });

  CLI::App* const play = testbed->add_subcommand(
      "replay", "Print the messages to the robots, and compare recomputed poses with the recorded ones");
  play->add_option("folder", options->folder, "A folder made by `testbed record`, or by --record")
      ->required()
      ->check(CLI::ExistingDirectory);
  play->callback([options] { end_with(replay(*options)); });
  testbed->footer(
      "Examples:\n  arkmesh testbed record lab.toml --out day1 --seconds 60\n  arkmesh testbed replay day1 | less\n"
      "`record` runs the lab as `arkmesh lab` does. `replay` exits with 1 if poses differ, or none could be compared.");
}

}  // namespace arkmesh::cli
