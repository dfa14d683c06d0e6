// Labs in one process whose arenas keep real time by the steps of the run instead of the wall: a step is a millisecond.
// So free exchange, with delays and cuts, can be run faster than life and gives the same result each time.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/arenas.hpp"
#include "app/joint_run.hpp"
#include "hal/arenas/arena.hpp"

namespace arkmesh::tests {

// Milliseconds since the run began; whoever steps the labs sets it.
inline hal::LabTime& stepped_time() {
  static hal::LabTime now{0};
  return now;
}

// Another arena, which is at lab time t no earlier than t after its robots began to move. Lab time begins `late` after
// the first that asks.
class SteppedArena final : public hal::Arena {
 public:
  explicit SteppedArena(std::unique_ptr<hal::Arena> arena) : arena_(std::move(arena)), info_(arena_->info()) {
    info_.can_wait = false;
  }
  const hal::ArenaInfo& info() const override { return info_; }
  const hal::Clock& clock() const override { return arena_->clock(); }
  hal::PoseSource& poses() override { return arena_->poses(); }
  hal::RobotLink& robots() override { return arena_->robots(); }
  bool advance_to(hal::LabTime t) override {
    if (t > hal::LabTime{0}) {
      if (begun_ < hal::LabTime{0}) begun_ = stepped_time();
      if (stepped_time() - begun_ < t) return false;
    }
    return arena_->advance_to(t);
  }
  void serve() override { arena_->serve(); }
  // Its time passes with the run's steps, which never wait for it.
  hal::TimePoint next_service() const override { return hal::TimePoint::max(); }
  std::string waiting_for() const override { return arena_->waiting_for(); }
  bool end() override { return arena_->end(); }
  std::vector<hal::NotStanding> not_standing() const override { return arena_->not_standing(); }
  const hal::Counters& counters() const override { return arena_->counters(); }

 private:
  std::unique_ptr<hal::Arena> arena_;
  hal::ArenaInfo info_;
  hal::LabTime begun_{-1};
};

// From now on arena.use = "stepped" is an arena of ODE that keeps the time of the run's steps.
inline void add_stepped_arena() {
  auto& rows = app::arena_rows();
  for (const hal::ArenaRow& row : rows)
    if (row.name == "stepped") return;
  for (const hal::ArenaRow& row : rows)
    if (row.name == "ode") {
      hal::ArenaRow stepped = row;
      stepped.name = "stepped";
      stepped.make = [](const hal::Section& arena, const hal::ArenaRequest& request) -> std::unique_ptr<hal::Arena> {
        for (const hal::ArenaRow& each : app::arena_rows())
          if (each.name == "ode") return std::make_unique<SteppedArena>(each.make(arena, request));
        return nullptr;
      };
      rows.push_back(std::move(stepped));
      return;
    }
}

// A step of the run, which is a millisecond for its arenas. False: all labs have ended.
inline bool step(app::JointRun& run) {
  stepped_time() = std::chrono::milliseconds(run.steps());
  return run.step();
}

}  // namespace arkmesh::tests
