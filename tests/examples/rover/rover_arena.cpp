#include "tests/examples/rover/rover_arena.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "hal/arenas/arena_config.hpp"
#include "hal/arenas/newest_frame.hpp"
#include "hal/time/pacer.hpp"
#include "tests/examples/rover/roll_call.hpp"
#include "tests/examples/rover/rover_base.hpp"
#include "tests/examples/rover/simulated_rovers.hpp"

namespace arkmesh::examples::rover {
namespace {

using namespace std::chrono_literals;
using hal::LabTime;
using hal::TimePoint;

constexpr std::chrono::milliseconds listen_period = 10ms, roll_call_period = 20ms, longest_end = 1s;

class RoverArena final : public hal::Arena {
 public:
  RoverArena(hal::ArenaInfo info, std::chrono::microseconds names_within, std::shared_ptr<ByteStream> stream,
             std::shared_ptr<SpotCamera> camera, hal::WallTime& wall)
      : info_(std::move(info)),
        names_within_(names_within),
        wall_(wall),
        stream_(std::move(stream)),
        camera_(std::move(camera)),
        base_(info_, *stream_, counters_),
        roll_call_(info_.robots) {}

  // Rovers drive on until they are told otherwise, so the last word must be a stop, also after an exception.
  ~RoverArena() override { hal::end(*this, wall_); }

  const hal::ArenaInfo& info() const override { return info_; }
  const hal::Clock& clock() const override { return clock_; }
  hal::PoseSource& poses() override { return poses_; }
  hal::RobotLink& robots() override { return base_; }
  const hal::Counters& counters() const override { return counters_; }

  bool advance_to(LabTime t) override {
    assert(t >= clock_.now() && "lab time never decreases");
    serve();
    if (frames_ == 0 && !call_the_roll()) return false;
    if (t == clock_.now()) return true;
    base_.release();
    for (; frames_ * info_.frame_period <= t; make_frame()) {
      wanted_at_ = pacer_.moment_of(frames_ * info_.frame_period);  // lab time begins with the first one
      if (wall_.now() < wanted_at_) return false;
    }
    const bool there = pacer_.reached(t);
    wanted_at_ = pacer_.next();
    if (there) clock_.set(t);
    return there;
  }

  void serve() override {
    base_.listen();
    served_at_ = wall_.now();
  }

  TimePoint next_service() const override { return std::min(wanted_at_, served_at_ + listen_period); }

  std::string waiting_for() const override { return called_at_ && frames_ == 0 ? missing() : std::string(); }

  std::vector<hal::NotStanding> not_standing() const override { return base_.not_standing(); }
  bool end() override {
    const TimePoint now = wall_.now();
    if (!ending_at_) {
      ending_at_ = now;
      base_.stop();
    }
    serve();
    if (base_.all_stand() || now - *ending_at_ > longest_end) return true;
    base_.repeat();
    wanted_at_ = now + roll_call_period;
    return false;
  }

 private:
  // Frame 0: every rover has shown who it is. Nobody moves meanwhile, because nobody was told to go. False: not yet.
  bool call_the_roll() {
    const TimePoint now = wall_.now();
    if (!called_at_) called_at_ = wanted_at_ = now;
    if (now < wanted_at_) return false;
    roll_call_.look(camera_->look(), base_.shows());
    if (roll_call_.unnamed().empty()) {
      put_frame();
      wanted_at_ = TimePoint::max();
      return true;
    }
    if (now - *called_at_ > names_within_) throw std::runtime_error(fmt::format("gave up waiting for {}", missing()));
    base_.ask_to_show(roll_call_.unnamed().front());
    wanted_at_ = now + roll_call_period;
    return false;
  }

  std::string missing() const {
    return fmt::format("the rovers: {} of {} have not shown their light ({}); are they switched on and in sight?",
                       roll_call_.unnamed().size(), info_.robots.size(), fmt::join(roll_call_.unnamed(), ", "));
  }

  void make_frame() {
    base_.listen();
    roll_call_.look(camera_->look(), base_.shows());
    base_.repeat();
    if (const auto unnamed = roll_call_.unnamed(); !unnamed.empty()) {
      counters_.add("poses.lost.robot", unnamed.size());
      base_.ask_to_show(unnamed.front());
    }
    put_frame();
  }

  void put_frame() {
    poses_.put({.stamp = frames_ * info_.frame_period,
                .number = static_cast<std::uint32_t>(frames_),
                .robots = roll_call_.seen()});
    ++frames_;
  }

  const hal::ArenaInfo info_;
  const std::chrono::microseconds names_within_;
  hal::WallTime& wall_;
  const std::shared_ptr<ByteStream> stream_;
  const std::shared_ptr<SpotCamera> camera_;
  hal::Counters counters_;
  hal::OwnedClock clock_;
  hal::NewestFrame poses_{counters_};
  hal::Pacer pacer_{info_.frame_period, counters_, wall_};
  RoverBase base_;
  RollCall roll_call_;
  std::int64_t frames_ = 0;                               // made so far; also the next one's number
  std::optional<TimePoint> called_at_, ending_at_;        // the first advance_to, the first end
  TimePoint wanted_at_ = TimePoint::max(), served_at_{};  // when an answer of false is worth another question
};

}  // namespace

std::unique_ptr<hal::Arena> make_rover_arena(const hal::Section& arena, const std::string& lab,
                                             std::shared_ptr<ByteStream> stream, std::shared_ptr<SpotCamera> camera,
                                             hal::WallTime& wall) {
  const hal::ArenaConfig config = hal::read_arena_config(arena, body_radius_m);
  hal::ArenaInfo info;
  info.make = "rover";
  info.body_radius_m = body_radius_m;
  info.drive.speed_m_s = speed_m_s;
  info.max_robot = 0xffff;
  info.kinds = 8;
  info.values = 10'000;
  info.commands = {hal::FleetCommand::Kind::run, hal::FleetCommand::Kind::pause};
  info.name = lab;
  info.platform = "rover";
  info.width_m = config.width_m;
  info.height_m = config.height_m;
  for (int i = 0; i < config.robots; ++i) info.robots.push_back(static_cast<hal::RobotId>(i));
  info.can_wait = false;
  info.frame_period = config.frame_period;
  const double names_within_s = arena.section("rover").get("names_within_s", 10.0, {.range = {0.1, 3600}});
  return std::make_unique<RoverArena>(std::move(info), std::chrono::microseconds{std::llround(names_within_s * 1e6)},
                                      std::move(stream), std::move(camera), wall);
}

hal::ArenaRow rover_arena_row() {
  return {"rover", {"rover"}, hal::ArenaRow::Robots::none, [](const hal::Section& arena, const hal::ArenaRequest& who) {
            const hal::ArenaConfig config = hal::read_arena_config(arena, body_radius_m);
            const auto rovers = std::make_shared<SimulatedRovers>(SimulatedRovers::Settings{
                .width_m = config.width_m,
                .height_m = config.height_m,
                .robots = config.robots,
                .damage = arena.section("rover").get("damage", 0.0, {.range = {0, 1}}),
                .seed = who.seed,
            });
            return make_rover_arena(arena, who.lab, rovers, rovers);
          }};
}

}  // namespace arkmesh::examples::rover
