// A lab that stands in for one that runs the original: its arena and scenario, made from the lab's file.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "app/own_parts.hpp"
#include "hal/stop_request.hpp"
#include "hal/time/wall_time.hpp"
#include "mark/original_arena.hpp"
#include "mark/settings.hpp"

namespace arkmesh::mark {

class StandIn final : public app::OwnParts {
 public:
  using MakeLink = std::function<std::unique_ptr<Link>(hal::EventLoop&, const Settings&, Role)>;
  // `link` and `wall`: for tests, which bring their own.
  explicit StandIn(Role role, MakeLink link = make_link(), hal::WallTime& wall = hal::machine_time());

  // Throws ConfigError where the original cannot follow the file, and std::runtime_error where its port is taken.
  Made make(const hal::Config& config, const lab::RunConfig& run, hal::EventLoop& loop) override;

  // Why the lab and the original cannot share a world; empty when they can. While the arena lives.
  std::string conflict() const { return conversation_ ? conversation_->conflict() : ""; }
  // After the lab's end: listens to the original until that goes, which closing first would kill, or until `stop` is
  // wished again. While the arena lives.
  void stay(hal::StopRequest& stop);
  // The original is there.
  bool is_connected() const { return arena_ && arena_->original().up(); }

 private:
  static MakeLink make_link();
  Made make_dhtf(const hal::Config& config, const lab::RunConfig& run, OriginalParts parts);
  Made make_cre(const hal::Config& config, const lab::RunConfig& run, OriginalParts parts);
  std::unique_ptr<hal::Arena> make_arena(OriginalParts parts, const lab::RunConfig& run);

  const Role role_;
  const MakeLink link_;
  hal::WallTime& wall_;
  hal::EventLoop* loop_ = nullptr;
  OriginalArena* arena_ = nullptr;              // the lab's
  const Conversation* conversation_ = nullptr;  // the arena's
};

}  // namespace arkmesh::mark
