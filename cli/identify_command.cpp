// `arkmesh identify`: which robot on the table is which.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "cli/status_line.hpp"
#include "hal/platforms/kilobot/robot_ids.hpp"
#include "testbed/chore_table.hpp"
#include "tracker/identity/ark_identifier.hpp"
#include "tracker/identity/identity_keeper.hpp"

namespace arkmesh::cli {
namespace {

struct IdentifyOptions {
  testbed::ChoreOptions table;
  std::string protocol = "spelled", ids;
  bool any = false;
  double most_s = 0;  // 0: as long as it may take
};

struct Found {
  std::map<hal::RobotId, tracker::Naming> robots;
  std::vector<hal::RobotId> duplicates, strangers;
  int rounds = 0;
  double took_s = 0;
};

using Tracks = std::map<tracker::TrackNumber, tracker::Track>;

void keep(Tracks& tracks, std::span<const tracker::Track> seen) {
  tracks.clear();
  for (const tracker::Track& track : seen) tracks.emplace(track.number, track);
}

Found ask_spelled(testbed::ChoreTable& table, const std::vector<hal::RobotId>& expected, double most_s,
                  Tracks& tracks) {
  tracker::IdentityKeeper keeper({.expected = expected});
  StatusLine status("identify");
  Found out;
  std::map<tracker::TrackNumber, float> confidence;
  while (!keeper.settled(3) && table.seconds() < most_s && !operator_stops()) {
    const auto seen = table.next_picture(keeper.question());
    keeper.on_frame(table.now(), seen);
    keep(tracks, seen);
    for (const tracker::Naming& naming : keeper.take_namings()) {
      table.name(naming.track, naming.robot);
      confidence[naming.track] = naming.confidence;
      out.took_s = table.seconds();
    }
    const auto progress = keeper.progress();
    status.show(fmt::format(
        "{:.1f} s, {} of {} robots named, {}", table.seconds(), progress.named, progress.tracks,
        progress.digits ? fmt::format("round {}, digit {} of {}", progress.passes, progress.digit, progress.digits)
                        : "nobody is asked"));
  }
  for (const auto& [number, track] : tracks)
    if (const auto robot = keeper.robot_of(number)) out.robots[*robot] = {number, *robot, confidence[number]};
  out.duplicates.assign(keeper.duplicates().begin(), keeper.duplicates().end());
  out.strangers.assign(keeper.strangers().begin(), keeper.strangers().end());
  out.rounds = keeper.progress().passes;
  return out;
}

Found ask_as_ark(testbed::ChoreTable& table, const std::vector<hal::RobotId>& expected, double most_s, bool runtime,
                 Tracks& tracks) {
  tracker::ArkIdentifier identifier({.candidates = expected, .runtime = runtime});
  StatusLine status("identify");
  Found out{.rounds = 1};
  // the first picture with somebody in it
  while (tracks.empty() && table.seconds() < most_s && !operator_stops()) keep(tracks, table.next_picture({}));
  while (!identifier.finished() && table.seconds() < most_s && !operator_stops()) {
    const auto seen = table.next_picture(identifier.question());
    identifier.on_frame(table.now(), seen);
    keep(tracks, seen);
    for (const tracker::Naming& naming : identifier.take_namings()) {
      out.robots[naming.robot] = naming;
      out.took_s = table.seconds();
    }
    if (const auto called = identifier.called())
      status.show(fmt::format("{:.1f} s, {} of {} robots named, calling {}", table.seconds(), identifier.named(),
                              tracks.size(), *called));
  }
  out.duplicates = identifier.duplicates();
  return out;
}

int identify(const IdentifyOptions& options) {
  testbed::ChoreTable table(options.table);
  std::vector<hal::RobotId> expected =
      options.ids.empty() ? table.info().robots : testbed::parse_ids(options.ids, table.info().max_robot, "--ids");
  std::sort(expected.begin(), expected.end());
  if (options.any) expected.clear();
  const bool spelled = options.protocol == "spelled";
  const auto candidates = static_cast<double>(expected.empty() ? table.info().max_robot + 1 : expected.size());
  const double most_s = options.most_s > 0 ? options.most_s : spelled ? 120 : 60 + 3 * candidates;
  Tracks tracks;
  const Found found = spelled ? ask_spelled(table, expected, most_s, tracks)
                              : ask_as_ark(table, expected, most_s, options.protocol == "ark-runtime", tracks);

  if (!found.robots.empty())
    fmt::print("{:>6} {:>9} {:>9} {:>12} {:>10}\n", "robot", "x_m", "y_m", "heading_deg", "confidence");
  for (const auto& [robot, naming] : found.robots) {
    const hal::Pose pose = tracks.contains(naming.track) ? tracks.at(naming.track).in_arena : hal::Pose{};
    fmt::print("{:>6} {:>9.4f} {:>9.4f} {:>12.1f} {:>10.2f}\n", robot, pose.x_m, pose.y_m,
               pose.heading_rad * 180 / std::numbers::pi, naming.confidence);
    std::erase_if(tracks, [&](const auto& track) { return track.first == naming.track; });
  }
  for (const auto& [number, track] : tracks)
    fmt::print("nameless: a robot at x {:.4f} m, y {:.4f} m\n", track.in_arena.x_m, track.in_arena.y_m);
  std::vector<hal::RobotId> missing;
  for (hal::RobotId robot : expected)
    if (!found.robots.contains(robot)) missing.push_back(robot);
  if (!missing.empty()) fmt::print("not found: {}\n", hal::kilobot::in_words(missing));
  if (!found.duplicates.empty())
    fmt::print("several robots have the same id: {}; give them ids of their own with `arkmesh assign-ids`\n",
               hal::kilobot::in_words(found.duplicates));
  if (!found.strangers.empty()) fmt::print("not expected, but there: {}\n", hal::kilobot::in_words(found.strangers));
  fmt::print("{} of {} robots named in {:.1f} s\n", found.robots.size(),
             expected.empty() ? found.robots.size() + tracks.size() : expected.size(), found.took_s);
  return missing.empty() && !found.robots.empty() && (!options.any || tracks.empty()) ? 0 : 1;
}

}  // namespace

void add_identify_command(CLI::App& app) {
  const auto options = std::make_shared<IdentifyOptions>();
  CLI::App* command = add_command(app, "identify");
  command->add_option("file", options->table.file, "The lab's configuration file")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--set", options->table.sets, "Override a key: --set arena.use=kilobot")->allow_extra_args(false);
  command
      ->add_option("--protocol", options->protocol,
                   "spelled: programs with arkmesh_id.h, all robots at once; ark, ark-runtime: ARK's message 120 or "
                   "119, one by one")
      ->check(CLI::IsMember({"spelled", "ark", "ark-runtime"}))
      ->capture_default_str();
  command->add_option("--ids", options->ids, "Whom to expect, such as 0-11,40 (default: the lab's robots)");
  command->add_flag("--any", options->any, "Expect nobody in particular: whoever answers")->excludes("--ids");
  command
      ->add_option("--seconds", options->most_s,
                   "Give up after this time (default: 120, with ARK's messages 3 for each id)")
      ->check(CLI::Range(1.0, 1e5));
  command->footer(
      "Examples:\n  arkmesh identify lab.toml\n  arkmesh identify lab.toml --any\n  arkmesh identify lab.toml "
      "--protocol ark --ids 0-19\n"
      "Robots need not RUN. Ends with 1 when somebody expected was not found.");
  command->callback([options] {
    if (const int code = identify(*options)) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
