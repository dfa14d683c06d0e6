#include "mark/original_arena.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "hal/platforms/kilobot/body.hpp"
#include "mark/cre_conversation.hpp"

namespace arkmesh::mark {
namespace {

using namespace std::chrono_literals;
using OnPeerLost = lab::RunConfig::OnPeerLost;

constexpr hal::Led led_of(int commitment) {
  return commitment == 1 ? hal::Led::red : commitment == 2 ? hal::Led::blue : hal::Led::off;
}

}  // namespace

OriginalArena::OriginalArena(OriginalParts parts, const lab::RunConfig& run, hal::WallTime& wall)
    : conversation_(std::move(parts.conversation)),
      flying_(parts.flying),
      side_m_(parts.settings.side_m),
      on_lost_(run.on_peer_lost),
      patience_(run.patience),
      wall_(wall),
      original_(parts.settings, parts.role, parts.grammar, *conversation_, std::move(parts.link),
                run.on_peer_lost == OnPeerLost::go_on ? Original::Away::goes_on : Original::Away::stands_still,
                counters_, wall) {
  info_.name = run.lab;
  info_.platform = "m-ark";
  info_.make = "kilobot";
  info_.drive.speed_m_s = hal::kilobot::fastest_m_s;
  info_.body_radius_m = hal::kilobot::body_radius_m;
  info_.width_m = info_.height_m = side_m_;
  info_.can_wait = false;
  info_.starts_with_labs = true;
  info_.frame_period = parts.settings.flavour == Flavour::argos ? parts.settings.period : hal::LabTime{100ms};
  if (flying_)
    for (int i = 0; i < parts.settings.robots; ++i) info_.robots.push_back(static_cast<hal::RobotId>(i));
  info_.max_robot = info_.robots.empty() ? 0 : info_.robots.back();
}

void OriginalArena::serve() {
  original_.serve();
  for (const auto& [name, total] : original_.refusals().all()) counters_.set(name, total);
  if (!conversation_->conflict().empty() && std::exchange(may_refuse_, false))
    throw std::runtime_error(conversation_->conflict());
}

bool OriginalArena::advance_to(hal::LabTime t) {
  if (made_ >= 0 && t <= clock_.now()) return true;
  original_.open();
  if (t == hal::LabTime{0} ? !original_.may_begin() : !original_.reached(t)) {
    give_up_on_the_absent();
    return false;
  }
  clock_.set(t);
  make_frame(t);
  return true;
}

// The original is a peer of this lab: gate.on_peer_lost and gate.patience_s.
void OriginalArena::give_up_on_the_absent() {
  const auto since = original_.away_since();
  if (!since) return;
  if (on_lost_ == OnPeerLost::end && made_ > 0)
    throw std::runtime_error(
        fmt::format("{}; restart it and this lab (gate.on_peer_lost = \"end\")", original_.absence()));
  if (on_lost_ == OnPeerLost::pause && wall_.now() - *since > patience_)
    throw std::runtime_error(fmt::format("gave up waiting after {} s (gate.patience_s) for {}",
                                         std::chrono::floor<std::chrono::seconds>(patience_).count(),
                                         original_.absence()));
}

void OriginalArena::make_frame(hal::LabTime t) {
  const std::int64_t newest = t / info_.frame_period;
  if (newest <= made_) return;
  if (newest - made_ > 1) poses_.skip(static_cast<std::uint64_t>(newest - made_ - 1));
  made_ = newest;
  hal::PoseFrame frame{.stamp = newest * info_.frame_period, .number = static_cast<std::uint32_t>(newest)};
  if (flying_) {
    hal::RobotId id = 0;
    for (const FlyingRobot& robot : flying_->robots())
      // As the original's own peer takes them.
      frame.robots.push_back({.robot = id++,
                              .pose = {.x_m = robot.x_cm * 0.01 - side_m_ / 2, .y_m = robot.y_cm * 0.01 - side_m_ / 2},
                              .led = led_of(robot.commitment)});
  }
  poses_.put(std::move(frame));
}

std::string OriginalArena::waiting_for() const {
  std::string what = original_.absence();
  if (!original_.up()) return what;
  if (!conversation_->may_begin())
    what = fmt::format("{} of {}", conversation_->awaited(), what.empty() ? original_.name() : what);
  if (what.empty()) return {};
  if (!original_.newest_refusal().empty())
    what += fmt::format("; newest refused message: {}", original_.newest_refusal());
  return what;
}

// Nothing of it depends on lab time any more. Its connection stays.
bool OriginalArena::end() {
  may_refuse_ = false;
  original_.end();
  return true;
}

}  // namespace arkmesh::mark
