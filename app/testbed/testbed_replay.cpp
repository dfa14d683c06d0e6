#include "app/testbed/testbed_replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "emulator/said_words.hpp"
#include "hal/arenas/log_arena.hpp"
#include "hal/config/config.hpp"
#include "hal/files/whole_file.hpp"
#include "hal/record/event_log.hpp"
#include "testbed/pose_replay.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t most_facts = 1 << 20, most_config = 1 << 20;

void refuse_when_stopped(hal::StopRequest& stop) {
  if (stop.stopped()) throw std::runtime_error("the replay was stopped before its end");
}

double turn_between(double a, double b) {
  return std::abs(std::remainder(a - b, 2 * std::numbers::pi));
}

// Of a run, with overrides.
hal::Config config_of(const fs::path& run, const std::vector<std::string>& overrides = {}) {
  const fs::path file = run / "config.toml";
  const auto text = hal::whole_file(file, most_config);
  if (!text) throw std::runtime_error(fmt::format("{} cannot be read", file.string()));
  return hal::Config::from_text(*text, file.string(), overrides);
}

// The lab's settings, with the calibrations that lie in the record.
testbed::KilobotSettings settings_of(const TestbedRecord& record) {
  const auto cameras = [](const hal::Config& config) {
    return testbed::read_cameras(config.root().section("arena").section("kilobot"));
  };
  std::string list;
  const std::vector<testbed::CameraSettings> named = cameras(config_of(record.run));
  if (named.empty() || named.size() > 4)
    throw std::runtime_error(fmt::format("{} names {} cameras, so it is not from a testbed's run",
                                         (record.run / "config.toml").string(), named.size()));
  for (std::size_t i = 0; i < named.size(); ++i) {
    const std::string calibration = fs::absolute(record.raw / testbed::calibration_file_of(i)).string();
    if (!hal::whole_file(calibration, most_config))
      throw std::runtime_error(fmt::format("{} is missing or not a calibration file", calibration));
    list += fmt::format("{}{{source = \"{}\", calibration = {}, camera = {}}}", i == 0 ? "" : ", ", i,
                        hal::to_toml(calibration), hal::to_toml(named[i].name));
  }
  const hal::Config config = config_of(record.run, {fmt::format("arena.kilobot.cameras=[{}]", list)});
  return testbed::read_kilobot_settings(config.root().section("arena"), "replay", named.size());
}

// The poses of the lab's log, one frame after the other.
class RecordedPoses {
 public:
  explicit RecordedPoses(const fs::path& log)
      : config_(hal::Config::from_text("", log.string(), {"arena.replay.log=" + hal::to_toml(log.string())})),
        arena_(hal::make_log_arena(config_.root().section("arena"), "replay", {}, hal::LabTime{0})) {}
  // That frame; nothing when the log holds none of that number.
  std::optional<hal::PoseFrame> at(const testbed::FrameLine& taken) {
    if (taken.stamp < arena_->clock().now()) throw std::runtime_error("the record's frames are not in order of time");
    arena_->advance_to(taken.stamp);
    if (auto newer = arena_->poses().latest()) frame_ = std::move(newer);
    return frame_ && frame_->number == taken.number ? frame_ : std::nullopt;
  }

 private:
  hal::Config config_;
  std::unique_ptr<hal::Arena> arena_;
  std::optional<hal::PoseFrame> frame_;
};

class Comparison {
 public:
  explicit Comparison(const hal::ArenaInfo& info) : info_(info) {}

  void compare(const hal::PoseFrame& lab, const std::optional<hal::PoseFrame>& again) {
    ++out.frames;
    std::string difference;
    if (again)
      difference = compare_robots(lab, *again);
    else
      difference = "no poses could be computed from the pictures";
    if (difference.empty()) return;
    if (out.different++ == 0)
      out.first_difference = fmt::format("frame {} ({:.1f} s): {}", lab.number,
                                         std::chrono::duration<double>(lab.stamp).count(), difference);
  }

  PoseComparison out;

 private:
  // The arena leaves out robots that are none of its own or far outside, and takes those at its wall for inside.
  bool is_left_out(const hal::Observation& seen) const {
    return !std::ranges::binary_search(info_.robots, seen.robot) ||
           std::abs(seen.pose.x_m) > info_.width_m / 2 + info_.body_radius_m ||
           std::abs(seen.pose.y_m) > info_.height_m / 2 + info_.body_radius_m;
  }

  std::string compare_robots(const hal::PoseFrame& lab, const hal::PoseFrame& again) {
    std::string difference;
    auto seen = again.robots.begin();
    const auto end = again.robots.end();
    for (const hal::Observation& was : lab.robots) {
      for (; seen != end && seen->robot < was.robot; ++seen)
        if (!is_left_out(*seen) && difference.empty())
          difference = fmt::format("the lab did not see robot {}, but the pictures show it", seen->robot);
      if (seen == end || seen->robot != was.robot) {
        if (difference.empty())
          difference = fmt::format("the lab saw robot {}, but the pictures do not show it", was.robot);
        continue;
      }
      const std::string one = compare(was, *seen++);
      if (difference.empty()) difference = one;
    }
    for (; seen != end; ++seen)
      if (!is_left_out(*seen) && difference.empty())
        difference = fmt::format("the lab did not see robot {}, but the pictures show it", seen->robot);
    return difference;
  }

  std::string compare(const hal::Observation& was, const hal::Observation& is) {
    ++out.poses;
    const double x_m = std::clamp(is.pose.x_m, -info_.width_m / 2, info_.width_m / 2);
    const double y_m = std::clamp(is.pose.y_m, -info_.height_m / 2, info_.height_m / 2);
    const double off_m = std::hypot(x_m - was.pose.x_m, y_m - was.pose.y_m);
    const double off_rad = turn_between(is.pose.heading_rad, was.pose.heading_rad);
    out.most_m = std::max(out.most_m, off_m);
    out.most_rad = std::max(out.most_rad, off_rad);
    if (off_m > same_within_m || off_rad > same_within_rad)
      return fmt::format("robot {} is {:.1f} mm and {:.1f} degrees off", was.robot, 1000 * off_m,
                         off_rad * 180 / std::numbers::pi);
    if (is.led != was.led) return fmt::format("the LED of robot {} has another colour", was.robot);
    return {};
  }

  const hal::ArenaInfo& info_;
};

}  // namespace

TestbedRecord find_testbed_record(const fs::path& folder) {
  TestbedRecord out;
  std::error_code error;
  const auto holds = [&error](const fs::path& place, const char* file) {
    return fs::is_regular_file(place / file, error);
  };
  out.raw = holds(folder / "raw", testbed::serial_file) ? folder / "raw" : folder;
  if (!holds(out.raw, testbed::serial_file))
    throw std::runtime_error(
        fmt::format("{} is not a testbed record: it holds neither raw/{} nor {}; `arkmesh testbed record` makes one",
                    folder.string(), testbed::serial_file, testbed::serial_file));
  if (out.raw != folder && holds(folder, "config.toml") && fs::is_regular_file(hal::log_in(folder), error))
    out.run = folder;
  if (!out.run.empty()) {
    const hal::Config config = config_of(out.run);
    out.layout = hal::kilobot::read_layout(config.root().section("arena"));
  }
  const auto text = hal::whole_file(out.raw / "facts.json", most_facts);
  const auto facts = nlohmann::json::parse(text.value_or(""), nullptr, false);
  if (!facts.is_object() || facts.value("record", nlohmann::json()) != 1)
    throw std::runtime_error(
        fmt::format("{} is missing, damaged, or of another version of arkmesh", (out.raw / "facts.json").string()));
  out.emulated = facts.value("arena", nlohmann::json()) == "emulated";
  return out;
}

void replay_words(const TestbedRecord& record, hal::StopRequest& stop,
                  const std::function<void(const SaidWord&)>& said) {
  const fs::path file = record.raw / testbed::serial_file;
  std::ifstream in(file);
  testbed::SerialLines lines(in, file.string());
  std::optional<SaidWord> word;
  emulator::replay_serial_line(lines, record.emulated, [&](const sim_ode::Transmission& sent) {
    if (word && word->message != sent.message) {
      refuse_when_stopped(stop);
      said(*word);
      word.reset();
    }
    if (!word)
      word = SaidWord{.first_us = sent.start_us, .last_us = 0, .copies = 0, .spoilt = 0, .message = sent.message};
    word->last_us = sent.start_us;
    ++(sent.clean ? word->copies : word->spoilt);
  });
  if (word) said(*word);
}

PoseComparison compare_poses(const TestbedRecord& record, hal::StopRequest& stop) {
  if (record.run.empty()) {
    PoseComparison none;
    none.not_compared = "the record does not come from a lab's run, so there are no poses to compare";
    return none;
  }
  const testbed::KilobotSettings settings = settings_of(record);
  RecordedPoses poses(hal::log_in(record.run));
  testbed::PoseReplay replay(record.raw, settings);
  Comparison comparison(settings.arena.info);
  while (const auto seen = replay.next()) {
    refuse_when_stopped(stop);
    if (!seen->taken) continue;
    const auto was = poses.at(*seen->taken);
    // The log of a run that was killed may end before its pictures.
    if (!was) {
      comparison.out.ended_by = fmt::format("the log holds no frame {}", seen->taken->number);
      break;
    }
    comparison.compare(*was, seen->poses);
  }
  if (comparison.out.ended_by.empty()) comparison.out.ended_by = replay.ended_by();
  return comparison.out;
}

}  // namespace arkmesh::app
