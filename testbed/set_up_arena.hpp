// An arena as set-up procedures see it, when robots have no names yet: tracks of whoever is there come in, broadcasts
// and messages go out. Real, emulated and simulated arenas alike.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/stop_request.hpp"
#include "testbed/tracks.hpp"
#include "tracker/follow/track.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::testbed {

class SetUpArena {
 public:
  // Waits, at a real testbed, until cameras and overhead controller are there; throws std::runtime_error when they do
  // not come, or when somebody stops it. The robots of a simulated arena have the procedure's program already; where it
  // gives poses instead of tracks, `seed` shuffles whose track is whose.
  SetUpArena(std::unique_ptr<hal::Arena> arena, bool simulated, std::uint64_t seed, hal::StopRequest& stop);

  const hal::ArenaInfo& info() const { return arena_->info(); }
  bool is_simulated() const { return simulated_; }
  // Since the arena was there.
  hal::LabTime now() const { return now_; }
  double seconds() const { return static_cast<double>(now_.count()) * 1e-6; }
  // Lets robots that wait begin, and what they showed before pass.
  void run();
  // Null where there are no cameras.
  const Tracks* tracks() const { return tracks_; }
  void wait(hal::LabTime span);
  // Lets time pass until the next picture; `question` is on the air meanwhile. The tracks stay until the next call.
  std::span<const tracker::Track> next_picture(const std::optional<tracker::Question>& question);
  // See Tracks; a simulated arena has no doubts.
  void name(tracker::TrackNumber track, hal::RobotId robot);
  void withhold(std::span<const hal::RobotId> doubtful);
  hal::RobotLink& robots() { return arena_->robots(); }
  hal::Arena& arena() { return *arena_; }

 private:
  void look_at_poses();

  std::unique_ptr<hal::Arena> arena_;
  Tracks* tracks_;  // owned by the arena; null: no cameras, poses without names are looked at
  bool simulated_;
  hal::LabTime now_{0}, next_copy_{0};
  std::vector<tracker::TrackNumber> numbers_;  // where there are poses: of each robot
  std::vector<tracker::Track> seen_;
};

// "0-99,200" to ids in that order. Throws std::invalid_argument with one sentence: no such list, an id above `largest`,
// one twice.
std::vector<hal::RobotId> parse_ids(const std::string& text, hal::RobotId largest);

}  // namespace arkmesh::testbed
