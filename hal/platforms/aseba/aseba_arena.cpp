#include "hal/platforms/aseba/aseba_arena.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cassert>
#include <optional>
#include <stdexcept>
#include <utility>

#include "hal/arenas/inside_arena.hpp"
#include "hal/arenas/newest_frame.hpp"
#include "hal/arenas/robot_words.hpp"
#include "hal/arenas/stand_judge.hpp"
#include "hal/counted.hpp"
#include "hal/platforms/aseba/aseba_link.hpp"
#include "hal/time/pacer.hpp"

namespace arkmesh::hal::aseba {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds serve_each = 10ms;
constexpr std::chrono::milliseconds picture_within = 2s;  // two pictures of a camera that is there
constexpr std::chrono::milliseconds at_least = 1200ms;    // at the start, in which two nodes of one number show
constexpr std::chrono::milliseconds stand_within = 3s;    // at the end

class AsebaArena final : public Arena {
 public:
  AsebaArena(const AsebaSettings& settings, std::vector<Connection> connections, std::unique_ptr<Eyes> eyes,
             WallTime& wall)
      : wall_(wall),
        info_(settings.info),
        names_within_(settings.names_within),
        may_miss_(settings.may_miss),
        eyes_(std::move(eyes)),
        nodes_(std::move(connections), info_.robots, make_of(settings.make), own_counters_),
        link_(info_, nodes_, settings.words_per_s, own_counters_),
        judge_(info_.robots, info_.drive.speed_m_s) {}

  // Robots drive on until somebody tells them otherwise, so the last word is a stop, also after an exception.
  ~AsebaArena() override { hal::end(*this, wall_); }

  const ArenaInfo& info() const override { return info_; }
  const Clock& clock() const override { return clock_; }
  PoseSource& poses() override { return poses_; }
  RobotLink& robots() override { return link_; }
  const Counters& counters() const override {
    counters_ = own_counters_;
    counters_.merge(eyes_->counters());
    return counters_;
  }

  bool advance_to(LabTime t) override {
    assert(t >= clock_.now() && "lab time never decreases");
    serve();
    if (frames_ == 0 && !begin()) return false;
    if (t == clock_.now()) return true;
    link_.release();
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
    const TimePoint now = wall_.now();
    if (now < served_at_ + serve_each) return;
    served_at_ = now;
    link_.poll(now);
    if (link_.told_since() == judged_since_) return;
    judged_since_ = link_.told_since();
    judge_.begin();
  }

  TimePoint next_service() const override { return std::min(wanted_at_, served_at_ + serve_each); }

  std::string waiting_for() const override {
    return begun_at_ && frames_ == 0 ? "the robots: " + missing() : std::string();
  }

  // A robot stands when its wheels do, as its node says, and no camera sees it move; one whose node says nothing stands
  // when cameras saw it stand for long enough.
  std::vector<NotStanding> not_standing() const override {
    std::vector<NotStanding> out = link_.not_standing();
    if (!link_.should_stand()) return out;
    const std::vector<NotStanding> seen = judge_.not_standing(wall_.now());
    const auto judged = [&](RobotId robot) { return std::ranges::find(seen, robot, &NotStanding::robot); };
    std::erase_if(out, [&](const NotStanding& robot) {
      return robot.why != NotStanding::Why::moving && judged(robot.robot) == seen.end();
    });
    for (const NotStanding& robot : seen)
      if (robot.why == NotStanding::Why::moving && !std::ranges::count(out, robot.robot, &NotStanding::robot))
        out.push_back(robot);
    std::ranges::sort(out, {}, &NotStanding::robot);
    return out;
  }

  bool end() override {
    const TimePoint now = wall_.now();
    if (!ending_at_) {
      ending_at_ = now;
      link_.finish();
      served_at_ = {};
      wanted_at_ = now;
    }
    serve();
    if (link_.not_standing().empty() || now - *ending_at_ > stand_within) {
      wanted_at_ = TimePoint::max();
      return true;
    }
    wanted_at_ = now + serve_each;
    return false;
  }

 private:
  // Frame 0: every node answers and every marker is seen. Nobody moves meanwhile. False: not yet.
  bool begin() {
    const TimePoint now = wall_.now();
    if (!begun_at_) begun_at_ = wanted_at_ = now;
    if (now < wanted_at_) return false;
    auto frame = look();
    if (frame) picture_at_ = now;
    const bool late = now - *begun_at_ > names_within_;
    const std::size_t absent = unready().size();
    if (late &&
        (!picture_at_ || now - *picture_at_ > picture_within || absent > may_miss_ || absent == info_.robots.size()))
      throw std::runtime_error(
          fmt::format("the robots were not ready within {} s: {}", names_within_.count() / 1'000'000, missing()));
    if (!frame || now - *begun_at_ < at_least || (absent > 0 && !late)) {
      wanted_at_ = now + info_.frame_period;
      return false;
    }
    if (absent > 0) {
      own_counters_.add("robots.missing_at_start", absent);
      spdlog::warn("the lab starts without {} of {}: {}", absent, counted(info_.robots.size(), "robot"), missing());
    }
    put(std::move(*frame));
    wanted_at_ = TimePoint::max();
    return true;
  }

  std::vector<RobotId> unready() const {
    std::vector<RobotId> out;
    for (const RobotId robot : info_.robots)
      if (!nodes_.is_here(robot) || nodes_.is_twice(robot) || std::ranges::count(eyes_->missing(), robot) > 0)
        out.push_back(robot);
    return out;
  }

  std::string missing() const {
    std::string out = nodes_.missing();
    const auto also = [&out](const std::string& why) { out += (out.empty() ? "" : "; ") + why; };
    if (!eyes_->error().empty())
      also(eyes_->error());
    else if (!eyes_->missing().empty())
      also(fmt::format("no camera sees the markers of robots {}", in_words(eyes_->missing())));
    return out.empty() ? "starting" : out;
  }

  std::optional<PoseFrame> look() {
    const TimePoint now = wall_.now();
    eyes_->look(std::chrono::duration_cast<LabTime>(now - made_));
    auto frame = eyes_->latest();
    if (frame) judge_.look(*frame, now);
    return frame;
  }

  void make_frame() {
    auto frame = look();
    serve();
    if (frame) {
      if (const std::size_t lost = eyes_->missing().size(); lost > 0) own_counters_.add("poses.lost.robot", lost);
      return put(std::move(*frame));
    }
    ++frames_;  // a gap in the numbers tells those who listen
    own_counters_.add("poses.lost.no_picture");
  }

  void put(PoseFrame frame) {
    frame.stamp = frames_ * info_.frame_period;
    frame.number = static_cast<std::uint32_t>(frames_++);
    for (Observation& robot : frame.robots) robot.led = link_.led(robot.robot);
    keep_inside(frame, info_, own_counters_);
    poses_.put(std::move(frame));
  }

  WallTime& wall_;
  const ArenaInfo info_;
  const std::chrono::microseconds names_within_;
  const std::size_t may_miss_;
  std::unique_ptr<Eyes> eyes_;
  Counters own_counters_;
  mutable Counters counters_;  // with those of the eyes, brought up to date when somebody looks
  OwnedClock clock_;
  NewestFrame poses_{own_counters_};
  Pacer pacer_{info_.frame_period, own_counters_, wall_};
  Nodes nodes_;
  AsebaLink link_;
  StandJudge judge_;
  const TimePoint made_ = wall_.now();
  std::optional<TimePoint> judged_since_;
  std::optional<TimePoint> begun_at_, ending_at_;         // the first advance_to, the first end
  std::optional<TimePoint> picture_at_;                   // the last look while beginning that gave a frame
  TimePoint wanted_at_ = TimePoint::max(), served_at_{};  // when an answer of false is worth another question
  std::int64_t frames_ = 0;                               // made or lost so far; also the next one's number
};

}  // namespace

std::unique_ptr<Arena> make_aseba_arena(const AsebaSettings& settings, std::vector<Connection> connections,
                                        std::unique_ptr<Eyes> eyes, WallTime& wall) {
  return std::make_unique<AsebaArena>(settings, std::move(connections), std::move(eyes), wall);
}

}  // namespace arkmesh::hal::aseba
