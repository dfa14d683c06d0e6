// What a real arena offers to set-up procedures, which find out themselves who is who: tracks of whoever is there come
// in, questions and names go out.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "testbed/arena_monitor.hpp"
#include "tracker/identity/name_keeper.hpp"

namespace arkmesh::testbed {

// What the cameras gave at the last look, each as in Look; before the first nothing.
struct LastLook {
  hal::LabTime now{-1};
  std::vector<cv::Mat> pictures;
  std::vector<hal::LabTime> arrived;
};

class Tracks {
 public:
  virtual ~Tracks() = default;
  virtual const LastLook& last_look() const = 0;
  // Of the newest pictures. Their numbers say nothing of ids.
  virtual std::span<const tracker::Track> tracks() const = 0;
  // What all robots hear over and over, from the next pictures on.
  virtual void ask(const std::optional<tracker::Question>& question) = 0;
  // The track has been found to be that robot: whatever doubt the tracker had is over.
  virtual void name(tracker::TrackNumber track, hal::RobotId robot) = 0;
  // Robots that nothing may be said to by their id, until the next call.
  virtual void withhold(std::span<const hal::RobotId> doubtful) = 0;
};

// Stands where names are found out and leaves that to a set-up procedure. Pose frames hold nobody.
class UnnamedTracks final : public tracker::NameKeeper, public Tracks {
 public:
  // `next`, which may be empty, hears of each look after this.
  Observer observer(Observer next) {
    return [this, next = std::move(next)](const Look& look) {
      last_look_ = {look.now, {look.pictures.begin(), look.pictures.end()}, {look.arrived.begin(), look.arrived.end()}};
      if (next) next(look);
    };
  }
  const LastLook& last_look() const override { return last_look_; }
  std::span<const tracker::Track> tracks() const override { return tracks_; }
  void ask(const std::optional<tracker::Question>& question) override { question_ = question; }
  void name(tracker::TrackNumber track, hal::RobotId robot) override { namings_.push_back({track, robot, 1}); }
  void withhold(std::span<const hal::RobotId> doubtful) override { withheld_.assign(doubtful.begin(), doubtful.end()); }

  void on_frame(hal::LabTime, std::span<const tracker::Track> seen) override {
    tracks_.assign(seen.begin(), seen.end());
  }
  std::optional<tracker::Question> question() const override { return question_; }
  std::vector<tracker::Naming> take_namings() override { return std::exchange(namings_, {}); }
  std::optional<hal::RobotId> robot_of(tracker::TrackNumber) const override { return std::nullopt; }
  std::span<const hal::RobotId> doubtful() const override { return withheld_; }
  bool everybody_named() const override { return true; }
  bool led_is_answer(tracker::TrackNumber) const override { return false; }
  const hal::Counters& counters() const override { return counters_; }

 private:
  LastLook last_look_;
  std::vector<tracker::Track> tracks_;
  std::optional<tracker::Question> question_;
  std::vector<tracker::Naming> namings_;
  std::vector<hal::RobotId> withheld_;
  hal::Counters counters_;
};

// `arena`, which owns `tracks`, with them within reach of tracks_of.
std::unique_ptr<hal::Arena> with_tracks(std::unique_ptr<hal::Arena> arena, Tracks& tracks);

// Null when the arena has poses only.
Tracks* tracks_of(hal::Arena& arena);

}  // namespace arkmesh::testbed
