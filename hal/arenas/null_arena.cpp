// Standing robots on a grid. No state but the clock, so a run of any length costs nothing.
#include "hal/arenas/null_arena.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>

#include "hal/arenas/arena_config.hpp"
#include "hal/arenas/newest_frame.hpp"
#include "hal/arenas/silent_link.hpp"
#include "hal/arenas/solids.hpp"
#include "hal/time/pacer.hpp"

namespace arkmesh::hal {

namespace {

class NullArena final : public Arena {
 public:
  NullArena(const ArenaConfig& config, Solids solids, const std::string& lab, const RobotKind& robot)
      : info_{robot}, poses_(counters_), link_(info_, counters_) {
    info_.obstacles = std::move(solids.obstacles);
    info_.objects = std::move(solids.objects);
    for (const MovableObject& object : info_.objects) frame_.objects.push_back({.pose = object.start});
    info_.name = lab;
    info_.platform = "null";
    info_.width_m = config.width_m;
    info_.height_m = config.height_m;
    info_.frame_period = config.frame_period;
    info_.can_wait = config.pace == 0;
    if (!info_.can_wait) pacer_.emplace(config.frame_period, counters_);

    // rows from south to north, each from west to east, cells of equal size
    const double robots = std::max(1, config.robots);
    const int columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(robots * config.width_m / config.height_m))));
    const int rows = std::max(1, static_cast<int>(std::ceil(robots / columns)));
    for (int i = 0; i < config.robots; ++i) {
      const auto id = static_cast<RobotId>(i);
      info_.robots.push_back(id);
      Observation& observation = frame_.robots.emplace_back();
      observation.robot = id;
      observation.pose.x_m = ((i % columns + 0.5) / columns - 0.5) * config.width_m;
      observation.pose.y_m = ((i / columns + 0.5) / rows - 0.5) * config.height_m;
    }
  }

  const ArenaInfo& info() const override { return info_; }
  const Clock& clock() const override { return clock_; }
  PoseSource& poses() override { return poses_; }
  RobotLink& robots() override { return link_; }
  const Counters& counters() const override { return counters_; }

  bool advance_to(LabTime t) override {
    assert(t >= clock_.now() && "lab time never decreases");
    if (pacer_ && t > clock_.now() && !pacer_->reached(t)) return false;
    clock_.set(t);
    const std::int64_t newest = t / info_.frame_period;
    if (newest <= made_) return true;
    if (newest - made_ > 1) poses_.skip(static_cast<std::uint64_t>(newest - made_ - 1));
    made_ = newest;
    frame_.number = static_cast<std::uint32_t>(newest);
    frame_.stamp = newest * info_.frame_period;
    poses_.put(frame_);
    return true;
  }
  void serve() override {}
  TimePoint next_service() const override { return pacer_ ? pacer_->next() : TimePoint::max(); }
  std::string waiting_for() const override { return {}; }
  bool end() override { return true; }
  std::vector<NotStanding> not_standing() const override { return {}; }

 private:
  Counters counters_;
  ArenaInfo info_;
  OwnedClock clock_;
  NewestFrame poses_;
  SilentLink link_;
  std::optional<Pacer> pacer_;  // none: can wait
  PoseFrame frame_;
  std::int64_t made_ = -1;  // number of the newest frame
};

}  // namespace

ArenaRow null_arena_row() {
  return {"null", {}, ArenaRow::Robots::none, [](const Section& arena, const ArenaRequest& request) {
            return make_null_arena(arena, request.lab, request.robot);
          }};
}

std::unique_ptr<Arena> make_null_arena(const Section& arena, const std::string& lab, const RobotKind& robot) {
  return std::make_unique<NullArena>(read_arena_config(arena, robot.body_radius_m), read_solids(arena), lab, robot);
}

}  // namespace arkmesh::hal
