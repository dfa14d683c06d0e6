#include "testbed/set_up_arena.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

#include "hal/random.hpp"

namespace arkmesh::testbed {
namespace {

constexpr hal::LabTime slice{20'000}, copies_apart{60'000};
constexpr int pictures_to_begin = 10;

}  // namespace

SetUpArena::SetUpArena(std::unique_ptr<hal::Arena> arena, bool simulated, std::uint64_t seed, hal::StopRequest& stop)
    : arena_(std::move(arena)), tracks_(tracks_of(*arena_)), simulated_(simulated) {
  if (!tracks_) {
    numbers_.resize(info().robots.size());
    std::iota(numbers_.begin(), numbers_.end(), 0u);
    hal::RandomStream chance(seed, info().name + "/chores");
    for (std::size_t i = numbers_.size(); i > 1; --i) std::swap(numbers_[i - 1], numbers_[chance.below(i)]);
  }
  hal::advance(*arena_, now_, stop);
}

void SetUpArena::run() {
  robots().command({.kind = hal::FleetCommand::Kind::run});
  for (int i = 0; i < pictures_to_begin; ++i) next_picture({});
}

void SetUpArena::wait(hal::LabTime span) {
  now_ += span;
  hal::advance(*arena_, now_);
}

std::span<const tracker::Track> SetUpArena::next_picture(const std::optional<tracker::Question>& question) {
  const hal::LabTime end = now_ + info().frame_period;
  if (tracks_) {
    tracks_->ask(question);
    now_ = end;
    hal::advance(*arena_, now_);
    return tracks_->tracks();
  }
  while (now_ < end) {
    if (question && now_ >= next_copy_) {
      robots().command({.kind = hal::FleetCommand::Kind::broadcast, .type = question->type, .data = question->data});
      next_copy_ = now_ + copies_apart;
    }
    now_ = std::min(end, now_ + slice);
    hal::advance(*arena_, now_);
  }
  look_at_poses();
  return seen_;
}

void SetUpArena::look_at_poses() {
  const std::optional<hal::PoseFrame> frame = arena_->poses().latest();
  if (!frame) return;
  seen_.clear();
  for (std::size_t i = 0; i < frame->robots.size(); ++i) {
    const hal::Observation& seen = frame->robots[i];
    seen_.push_back({.number = numbers_[i],
                     .in_arena = seen.pose,
                     .led = seen.led,
                     .led_seen = seen.led != hal::Led::off && seen.led != hal::Led::unknown,
                     .led_direction_rad = seen.pose.heading_rad,
                     .confidence = seen.confidence,
                     .heading_noise_rad = 0,
                     .age = seen.age});
  }
  std::sort(seen_.begin(), seen_.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
}

void SetUpArena::withhold(std::span<const hal::RobotId> doubtful) {
  if (tracks_) tracks_->withhold(doubtful);
}

void SetUpArena::name(tracker::TrackNumber track, hal::RobotId robot) {
  if (tracks_) tracks_->name(track, robot);
}

std::vector<hal::RobotId> parse_ids(const std::string& text, hal::RobotId largest) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(fmt::format("\"{}\" {}; write ids such as 0-99,200", text, why));
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
