// A lab's table for the chores before an experiment, when robots have no names yet: tracks of whoever is there come in,
// broadcasts and messages go out. Real tables, virtual rooms and simulated arenas alike.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/arena.hpp"
#include "hal/config.hpp"
#include "hal/random.hpp"
#include "tracker/question.hpp"
#include "tracker/track.hpp"

namespace arkmesh::testbed {

class ChoreNames;

struct ChoreOptions {
  std::string file;  // a lab's configuration
  std::vector<std::string> sets;
  std::string
      program;  // what simulated robots run instead of the lab's controller: a name in kilolib/programs, or nothing
};

class ChoreTable {
 public:
  // Waits, on a real table, until cameras and overhead controller are there. Throws ConfigError, and std::runtime_error
  // when they do not come.
  explicit ChoreTable(const ChoreOptions& options);
  ~ChoreTable();

  const hal::ArenaInfo& info() const { return arena_->info(); }
  // Robots of a simulation or a virtual room have the chore's program already.
  bool is_simulated() const { return simulated_; }
  // Since the table was there.
  hal::LabTime now() const { return now_; }
  double seconds() const { return static_cast<double>(now_.count()) * 1e-6; }
  // Lets time pass until the next picture; `question` is on the air meanwhile. The tracks stay until the next call. The
  // numbers of tracks say nothing of ids.
  std::span<const tracker::Track> next_picture(const std::optional<tracker::Question>& question);
  // The track has been found to be that robot: whatever doubt the tracker had is over.
  void name(tracker::TrackNumber track, hal::RobotId robot);
  // Robots that nothing may be said to by their id, until the next call.
  void withhold(std::span<const hal::RobotId> doubtful);
  hal::RobotLink& robots() { return arena_->robots(); }
  const hal::Counters& counters() const { return arena_->counters(); }
  hal::Arena& arena() { return *arena_; }

 private:
  void look_at_simulation();

  hal::Config config_;
  bool simulated_ = false;
  ChoreNames* names_ = nullptr;  // owned by the arena; null: no cameras, poses without names are looked at
  std::unique_ptr<hal::Arena> arena_;
  hal::LabTime now_{0}, next_copy_{0};
  std::vector<tracker::TrackNumber> numbers_;  // of simulated robots
  std::vector<tracker::Track> tracks_;
};

// "0-99,200" to ids in that order. Throws CLI::ValidationError for `option`: no such list, an id above `largest`, one
// twice.
std::vector<hal::RobotId> parse_ids(const std::string& text, hal::RobotId largest, const std::string& option);

}  // namespace arkmesh::testbed
