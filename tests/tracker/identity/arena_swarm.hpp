// A simulated arena and the eyes of a camera on it: pictures as tracks under numbers of their own, late, and questions
// put on the air as an overhead controller has time for them. For tests of everything that talks to robots it cannot
// name.
#pragma once

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/random.hpp"
#include "sim_ode/simulated_arena.hpp"
#include "tracker/follow/track.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::tests {

struct ArenaSwarmSettings {
  std::string program;  // path below the sources
  int robots = 1;
  double side_m = 1;
  std::vector<std::uint16_t> ids;  // by robot; empty: shuffled 0..robots-1
  std::string ode;                 // further lines of [arena.ode]
  hal::LabTime latency{150'000};   // of the camera
  double position_noise_m = 0;     // s.d. of what it says of each coordinate
  std::uint64_t seed = 1;
};

class ArenaSwarm {
 public:
  explicit ArenaSwarm(ArenaSwarmSettings settings)
      : settings_(std::move(settings)),
        config_(hal::Config::from_text(
            fmt::format(
                "[arena]\nrobots = {0}\nwidth_m = {1}\nheight_m = {1}\n[arena.ode]\ncontroller = \"{2}/{3}\"\n{4}\n",
                settings_.robots, settings_.side_m, ARKMESH_SOURCE_DIR, settings_.program, settings_.ode),
            "test.toml")),
        chance_(settings_.seed, "test/table") {
    ids = settings_.ids;
    if (ids.empty()) ids = shuffled<std::uint16_t>(0);
    track_of = shuffled<tracker::TrackNumber>(1000);
    hidden_since_.resize(track_of.size());
    arena_ = sim_ode::make_simulated_arena(config_.root().section("arena"), "lab", settings_.seed, {.ids = ids});
    arena_->advance_to(now);
    keep_picture();
  }

  // The next picture, 0.1 s later. Meanwhile `question` is on the air, over and over.
  const std::vector<tracker::Track>& next_picture(const std::optional<tracker::Question>& question) {
    for (const hal::LabTime end = now + hal::LabTime{100'000}; now < end;) {
      now += hal::LabTime{20'000};
      if (question && now >= next_copy_) {
        broadcast(*question);
        next_copy_ = now + hal::LabTime{60'000};
      }
      arena_->advance_to(now);
    }
    keep_picture();
    while (pictures_.size() > 1 && pictures_[1].stamp <= now - settings_.latency) pictures_.pop_front();
    tracks_.clear();
    for (std::size_t i = 0; i < track_of.size(); ++i) {
      const hal::Observation& seen = pictures_.front().robots[i];
      tracker::Track track{.number = track_of[i],
                           .in_arena = seen.pose,
                           .led = seen.led,
                           .led_seen = seen.led != hal::Led::off,
                           .confidence = 1};
      track.in_arena.x_m += settings_.position_noise_m * chance_.normal();
      track.in_arena.y_m += settings_.position_noise_m * chance_.normal();
      if (hidden_since_[i]) {
        track.age = now - *hidden_since_[i];
        track.led_seen = false;
        if (track.age > hal::LabTime{1'000'000}) continue;
      }
      tracks_.push_back(track);
    }
    std::sort(tracks_.begin(), tracks_.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
    return tracks_;
  }
  void broadcast(const tracker::Question& question) {
    arena_->robots().command(
        {.kind = hal::FleetCommand::Kind::broadcast, .type = question.type, .data = question.data});
  }
  void run() { arena_->robots().command({.kind = hal::FleetCommand::Kind::run}); }
  // A picture as it is, without latency.
  const hal::Observation& seen(std::size_t robot) const { return pictures_.back().robots.at(robot); }
  double seconds() const { return static_cast<double>(now.count()) * 1e-6; }

  void lift(std::size_t robot) {
    hidden_since_[robot] = now;
    arena_->take_off(static_cast<int>(robot));
  }
  // Under the track that is at that place now.
  void put(std::size_t robot, const hal::Pose& pose, tracker::TrackNumber track) {
    REQUIRE(arena_->put(static_cast<int>(robot), pose) == "");
    hidden_since_[robot].reset();
    track_of[robot] = track;
  }
  std::size_t robot_of(tracker::TrackNumber track) const {
    return static_cast<std::size_t>(std::find(track_of.begin(), track_of.end(), track) - track_of.begin());
  }
  std::size_t robot_with(std::uint16_t id) const {
    return static_cast<std::size_t>(std::find(ids.begin(), ids.end(), id) - ids.begin());
  }
  sim_ode::SimulatedArena& arena() { return *arena_; }

  std::vector<std::uint16_t> ids;              // by robot, at the beginning
  std::vector<tracker::TrackNumber> track_of;  // by robot
  hal::LabTime now{0};

 private:
  template <class T>
  std::vector<T> shuffled(T from) {
    std::vector<T> out(static_cast<std::size_t>(settings_.robots));
    std::iota(out.begin(), out.end(), from);
    for (std::size_t i = out.size(); i > 1; --i) std::swap(out[i - 1], out[chance_.below(i)]);
    return out;
  }
  void keep_picture() {
    if (auto frame = arena_->poses().latest()) pictures_.push_back(*std::move(frame));
  }

  ArenaSwarmSettings settings_;
  hal::Config config_;
  hal::RandomStream chance_;
  std::unique_ptr<sim_ode::SimulatedArena> arena_;
  hal::LabTime next_copy_{0};
  std::deque<hal::PoseFrame> pictures_;
  std::vector<std::optional<hal::LabTime>> hidden_since_;
  std::vector<tracker::Track> tracks_;
};

}  // namespace arkmesh::tests
