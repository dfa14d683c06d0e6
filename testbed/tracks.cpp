#include "testbed/tracks.hpp"

namespace arkmesh::testbed {
namespace {

class TracksArena final : public hal::Arena {
 public:
  TracksArena(std::unique_ptr<hal::Arena> arena, Tracks& tracks) : arena_(std::move(arena)), tracks_(tracks) {}
  const hal::ArenaInfo& info() const override { return arena_->info(); }
  const hal::Clock& clock() const override { return arena_->clock(); }
  hal::PoseSource& poses() override { return arena_->poses(); }
  hal::RobotLink& robots() override { return arena_->robots(); }
  bool advance_to(hal::LabTime t) override { return arena_->advance_to(t); }
  void serve() override { arena_->serve(); }
  hal::TimePoint next_service() const override { return arena_->next_service(); }
  std::string waiting_for() const override { return arena_->waiting_for(); }
  bool end() override { return arena_->end(); }
  std::vector<hal::NotStanding> not_standing() const override { return arena_->not_standing(); }
  const hal::Counters& counters() const override { return arena_->counters(); }

  Tracks& tracks() const { return tracks_; }

 private:
  std::unique_ptr<hal::Arena> arena_;
  Tracks& tracks_;
};

}  // namespace

std::unique_ptr<hal::Arena> with_tracks(std::unique_ptr<hal::Arena> arena, Tracks& tracks) {
  return std::make_unique<TracksArena>(std::move(arena), tracks);
}

Tracks* tracks_of(hal::Arena& arena) {
  auto* const own = dynamic_cast<TracksArena*>(&arena);
  return own ? &own->tracks() : nullptr;
}

}  // namespace arkmesh::testbed
