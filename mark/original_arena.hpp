// An arena whose time is the original's, with the robots that it tells of: those of a flying swarm, or none. What is
// said to robots cannot reach them and is refused.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/arenas/newest_frame.hpp"
#include "hal/arenas/silent_link.hpp"
#include "lab/run_config.hpp"
#include "mark/original.hpp"

namespace arkmesh::mark {

class CreClientConversation;

// What an arena is made of; it owns the first two.
struct OriginalParts {
  std::unique_ptr<Conversation> conversation;
  std::unique_ptr<Link> link;
  Settings settings;
  Role role = Role::server;
  Grammar grammar;
  const CreClientConversation* flying = nullptr;  // the conversation, when it tells of robots
};

class OriginalArena final : public hal::Arena {
 public:
  // `wall` outlives it. Throws std::runtime_error as Link::start does.
  OriginalArena(OriginalParts parts, const lab::RunConfig& run, hal::WallTime& wall = hal::machine_time());

  const hal::ArenaInfo& info() const override { return info_; }
  const hal::Clock& clock() const override { return clock_; }
  hal::PoseSource& poses() override { return poses_; }
  hal::RobotLink& robots() override { return robots_; }
  // Throws when the original stays away, as lab.gate says.
  bool advance_to(hal::LabTime t) override;
  // Throws, once, when the original and this lab cannot share a world.
  void serve() override;
  hal::TimePoint next_service() const override { return original_.next_service(); }
  std::string waiting_for() const override;
  bool end() override;
  std::vector<hal::NotStanding> not_standing() const override { return {}; }  // the original has its robots
  const hal::Counters& counters() const override { return counters_; }

  // For whoever serves it after the lab's end.
  Original& original() { return original_; }
  const Original& original() const { return original_; }

 private:
  void give_up_on_the_absent();
  void make_frame(hal::LabTime t);

  std::unique_ptr<Conversation> conversation_;
  const CreClientConversation* flying_;
  const double side_m_;
  const lab::RunConfig::OnPeerLost on_lost_;
  const std::chrono::microseconds patience_;
  hal::WallTime& wall_;
  hal::Counters counters_;
  hal::ArenaInfo info_;
  hal::OwnedClock clock_;
  hal::NewestFrame poses_{counters_};
  hal::SilentLink robots_{info_, counters_};
  std::int64_t made_ = -1;  // number of the newest frame
  bool may_refuse_ = true;
  Original original_;
};

}  // namespace arkmesh::mark
