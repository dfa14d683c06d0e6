#include "testbed/chore_table.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <numeric>
#include <set>
#include <utility>

#include "cli/operator_stop.hpp"
#include "emulator/room_arena.hpp"
#include "hal/platforms/kilobot/kilobot_arena.hpp"
#include "lab/run_config.hpp"
#include "sim_ode/host/robot_program.hpp"
#include "sim_ode/ode_arena.hpp"
#include "testbed/table_watch.hpp"

namespace arkmesh::testbed {

// Stands where names are found out, and lets the chore do it.
class ChoreNames final : public tracker::NameKeeper {
 public:
  void on_frame(hal::LabTime, std::span<const tracker::Track> seen) override {
    tracks.assign(seen.begin(), seen.end());
  }
  std::optional<hal::kilobot::Message> question() const override { return said; }
  std::vector<tracker::Naming> take_namings() override { return std::exchange(namings, {}); }
  // Frames hold nobody: tracks are what a chore looks at.
  std::optional<hal::RobotId> robot_of(tracker::TrackNumber) const override { return std::nullopt; }
  std::span<const hal::RobotId> doubtful() const override { return withheld; }
  bool everybody_named() const override { return true; }
  bool led_is_answer(tracker::TrackNumber) const override { return false; }
  const hal::Counters& counters() const override { return counters_; }

  std::vector<tracker::Track> tracks;
  std::optional<hal::kilobot::Message> said;
  std::vector<tracker::Naming> namings;
  std::vector<hal::RobotId> withheld;

 private:
  hal::Counters counters_;
};

namespace {

constexpr hal::LabTime slice{20'000}, copies_apart{60'000};

// Simulated robots have the chore's program loaded by hands that need no hex file.
std::vector<std::string> program_set(const ChoreOptions& options) {
  if (options.program.empty()) return {};
  return {"arena.ode.controller=" + (sim_ode::kilolib_folder() / "programs" / options.program).string()};
}

hal::Config read_config(const ChoreOptions& options) {
  hal::Config config = hal::Config::from_file(options.file, options.sets);
  if (config.root().section("arena").text("use", "ode") != "ode") return config;
  std::vector<std::string> sets = options.sets;
  for (const std::string& set : program_set(options)) sets.push_back(set);
  return hal::Config::from_file(options.file, sets);
}

}  // namespace

ChoreTable::ChoreTable(const ChoreOptions& options) : config_(read_config(options)) {
  const hal::Section root = config_.root(), arena = root.section("arena");
  const lab::RunConfig run = lab::read_run_config(root);
  const std::string use = arena.text("use", "ode");
  simulated_ = use != "kilobot";
  if (use == "kilobot" || use == "room") {
    auto names = std::make_unique<ChoreNames>();
    names_ = names.get();
    if (use == "room")
      arena_ = emulator::make_room_arena(arena, run.lab, run.seed, {}, std::move(names), program_set(options));
    else
      arena_ = hal::kilobot::make_kilobot_arena(
          arena, run.lab, testbed::make_table_watch(arena, {}, tracker::open_camera, std::move(names)));
  } else if (use == "ode") {
    arena_ = sim_ode::make_ode_arena(arena, run.lab, run.seed);
    numbers_.resize(arena_->info().robots.size());
    std::iota(numbers_.begin(), numbers_.end(), 0u);
    hal::RandomStream chance(run.seed, run.lab + "/chores");
    for (std::size_t i = numbers_.size(); i > 1; --i) std::swap(numbers_[i - 1], numbers_[chance.below(i)]);
  } else {
    arena.refuse("use", "has no robots to talk to; take \"kilobot\", \"room\" or \"ode\"");
  }
  hal::advance(*arena_, now_, cli::operator_stops);
}

ChoreTable::~ChoreTable() = default;

std::span<const tracker::Track> ChoreTable::next_picture(const std::optional<hal::kilobot::Message>& question) {
  const hal::LabTime end = now_ + arena_->info().frame_period;
  if (names_) {
    names_->said = question;
    now_ = end;
    hal::advance(*arena_, now_);
    return names_->tracks;
  }
  while (now_ < end) {
    if (question && now_ >= next_copy_) {
      robots().command({.kind = hal::FleetCommand::Kind::broadcast, .type = question->type, .data = question->data});
      next_copy_ = now_ + copies_apart;
    }
    now_ = std::min(end, now_ + slice);
    hal::advance(*arena_, now_);
  }
  look_at_simulation();
  return tracks_;
}

void ChoreTable::look_at_simulation() {
  const std::optional<hal::PoseFrame> frame = arena_->poses().latest();
  if (!frame) return;
  tracks_.clear();
  for (std::size_t i = 0; i < frame->robots.size(); ++i) {
    const hal::Sighting& seen = frame->robots[i];
    tracks_.push_back({.number = numbers_[i],
                       .in_arena = seen.pose,
                       .led = seen.led,
                       .led_seen = seen.led != hal::Led::off,
                       .confidence = seen.confidence,
                       .heading_sigma_rad = 0,
                       .age = seen.age});
  }
  std::sort(tracks_.begin(), tracks_.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
}

void ChoreTable::withhold(std::span<const hal::RobotId> doubtful) {
  if (names_) names_->withheld.assign(doubtful.begin(), doubtful.end());
}

void ChoreTable::name(tracker::TrackNumber track, hal::RobotId robot) {
  if (names_) names_->namings.push_back({track, robot, 1});
}

std::vector<hal::RobotId> parse_ids(const std::string& text, hal::RobotId largest, const std::string& option) {
  const auto refuse = [&](const std::string& why) {
    throw CLI::ValidationError(option, fmt::format("\"{}\" {}; write ids such as 0-99,200", text, why));
  };
  std::vector<hal::RobotId> out;
  std::set<hal::RobotId> known;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string part = text.substr(at, end - at);
    at = end + 1;
    unsigned long first = 0, last = 0;
    char rest = 0;
    const bool digits = part.size() <= 11 && !part.empty() &&
                        part.find_first_not_of("0123456789-") == std::string::npos && part.front() != '-' &&
                        part.back() != '-';
    const int found = digits ? std::sscanf(part.c_str(), "%lu-%lu%c", &first, &last, &rest) : 0;
    if (found != 1 && found != 2) refuse("is no list of ids");
    if (found == 1) last = first;
    if (found == 1 && part.find('-') != std::string::npos) refuse("is no list of ids");
    if (last < first) refuse("has a range that runs backwards");
    if (last > largest) refuse(fmt::format("has an id above {}", largest));
    for (unsigned long robot = first; robot <= last; ++robot) {
      if (!known.insert(static_cast<hal::RobotId>(robot)).second) refuse(fmt::format("has {} twice", robot));
      out.push_back(static_cast<hal::RobotId>(robot));
    }
  }
  return out;
}

}  // namespace arkmesh::testbed
