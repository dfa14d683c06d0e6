// Puts eyes and voice together in real time: looks at each frame's moment, serves the controller between. Callers wait.
#include "hal/platforms/kilobot/kilobot_arena.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cassert>
#include <iterator>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "hal/arenas/inside_arena.hpp"
#include "hal/arenas/newest_frame.hpp"
#include "hal/arenas/robot_words.hpp"
#include "hal/arenas/stand_judge.hpp"
#include "hal/counted.hpp"
#include "hal/platforms/kilobot/overhead_controller.hpp"
#include "hal/platforms/kilobot/port_lock.hpp"
#include "hal/time/pacer.hpp"

namespace arkmesh::hal::kilobot {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds seen_to_stand_within = 10s;  // robots that ran, when the arena ends
constexpr std::chrono::milliseconds told_within = 2s;            // robots that never did
constexpr std::chrono::milliseconds last_stop_takes = 300ms;     // for a stop, after that
constexpr LabTime blind_after = 1s;                              // no frame for so long is worth a line in the log

class KilobotArena final : public Arena {
 public:
  // What the beginning puts up with.
  struct Patience {
    std::chrono::microseconds names_within;
    std::size_t may_miss = 0;
  };

  KilobotArena(ArenaInfo info, const OverheadSettings& settings, Patience patience, std::unique_ptr<ByteStream> stream,
               std::unique_ptr<RobotMonitor> eyes, std::shared_ptr<StandGuard> guard, WallTime& wall)
      : wall_(wall),
        info_(std::move(info)),
        patience_(patience),
        eyes_(std::move(eyes)),
        poses_(own_counters_),
        pacer_(info_.frame_period, own_counters_, wall),
        port_(std::move(stream), own_counters_),
        controller_(info_, port_, settings, own_counters_),
        judge_(info_.robots, info_.drive.speed_m_s),
        guard_(std::move(guard)) {
    controller_.hold(true);
    controller_.command({.kind = FleetCommand::Kind::pause});
    tell_guard();
  }

  // The controller repeats what it heard last for ever, so its last word must be a stop, also when an exception took
  // whoever would have called end(). A testbed that is lost already cannot be told anything.
  ~KilobotArena() override {
    try {
      hal::end(*this, wall_);
    } catch (const std::exception&) {
    }
  }

  const ArenaInfo& info() const override { return info_; }
  const Clock& clock() const override { return clock_; }
  PoseSource& poses() override { return poses_; }
  RobotLink& robots() override { return controller_; }

  const Counters& counters() const override {
    counters_ = own_counters_;
    counters_.merge(eyes_->counters());
    return counters_;
  }

  bool advance_to(LabTime t) override {
    assert(t >= clock_.now() && "lab time never decreases");
    serve_controller();
    if (phase_ == Phase::beginning && !begin()) return false;
    if (t == clock_.now()) return true;
    phase_ = Phase::running;
    while (frames_ * info_.frame_period <= t) {
      const LabTime stamp = frames_ * info_.frame_period;
      wanted_at_ = pacer_.moment_of(stamp);  // lab time begins with the first one
      if (now() < wanted_at_) return false;
      make_frame(stamp);
    }
    const bool there = pacer_.reached(t);
    wanted_at_ = pacer_.next();
    if (there) clock_.set(t);
    return there;
  }

  void serve() override {
    serve_controller();
    // before lab time begins nobody asks for frames, and the eyes must not lose the robots meanwhile
    if (phase_ == Phase::ready && now() - looked_at_ >= info_.frame_period) look();
  }

  TimePoint next_service() const override { return std::min(wanted_at_, serve_at_); }

  std::string waiting_for() const override {
    return begun_at_ && phase_ == Phase::beginning ? "the testbed: " + missing() : std::string();
  }

  bool end() override {
    if (phase_ < Phase::ending) {
      phase_ = Phase::ending;
      if (!should_stand()) controller_.command({.kind = FleetCommand::Kind::pause});
      controller_.finish();
      last_until_ = now() + (ran_until_ ? seen_to_stand_within : told_within);
      wanted_at_ = now();
    }
    serve_controller();
    if (phase_ == Phase::ending && !see_them_stand()) return false;
    if (phase_ == Phase::ending) {
      judged_ = not_standing();
      if (guard_)
        guard_->tell(
            {*controller_.wanted(), judged_.empty() && port_.is_open(), true, controller_.said_since().has_value()});
      phase_ = Phase::stopping;
      controller_.stop_sending(now());
      last_until_ = now() + last_stop_takes;
      wanted_at_ = last_until_;
      serve_controller();
    }
    if (phase_ != Phase::ended && !controller_.is_silent(now()) && now() < last_until_) return false;
    phase_ = Phase::ended;
    wanted_at_ = TimePoint::max();
    return true;
  }

  std::vector<NotStanding> not_standing() const override {
    if (phase_ > Phase::ending) return judged_;
    if (!should_stand()) return {};
    if (controller_.said_since()) return judged_;
    std::vector<NotStanding> all;
    for (const RobotId robot : info_.robots) all.push_back({robot, NotStanding::Why::not_told});
    return all;
  }

 private:
  enum class Phase {
    beginning,  // until frame 0 is there
    ready,      // until lab time begins
    running,
    ending,    // robots are told to stand, until they were seen to
    stopping,  // what was still waiting has been dropped, the controller is told to stop
    ended,
  };

  TimePoint now() const { return wall_.now(); }

  // Frame 0: everybody is seen and named, and the way to them is open. Robots stand still meanwhile: nobody has told
  // them to run. False: not yet.
  bool begin() {
    if (!begun_at_) begun_at_ = wanted_at_ = now();
    if (now() < wanted_at_) return false;
    // eyes that look will ask, and a question that no robot can hear would be taken for unanswered
    auto frame = controller_.is_up() ? look() : std::nullopt;
    const TimePoint at = now();
    if (frame) picture_at_ = at;
    const bool sees = frame && controller_.is_up(), complete = sees && eyes_->everybody_named();
    // where no picture is new the next one tells
    if (!complete && at - *begun_at_ > patience_.names_within && (sees || !has_picture() || !controller_.is_up())) {
      if (!sees || !may_begin_without(unnamed()))
        throw std::runtime_error(fmt::format("the testbed was not ready within {} s: {}",
                                             patience_.names_within.count() / 1'000'000, missing()));
      begin_without(unnamed());
    } else if (!complete) {
      wanted_at_ = at + info_.frame_period;
      return false;
    }
    put(std::move(*frame), LabTime{0});
    controller_.hold(false);
    phase_ = Phase::ready;
    wanted_at_ = TimePoint::max();
    return true;
  }

  std::vector<RobotId> unnamed() const {
    std::vector<RobotId> out;
    std::ranges::set_intersection(eyes_->doubtful(), info_.robots, std::back_inserter(out));
    return out;
  }

  bool may_begin_without(const std::vector<RobotId>& robots) const {
    return !robots.empty() && robots.size() <= patience_.may_miss && robots.size() < info_.robots.size();
  }

  // The eyes go on looking for the others.
  void begin_without(const std::vector<RobotId>& robots) {
    own_counters_.add("robots.missing_at_start", robots.size());
    spdlog::warn("the lab starts without {} of {} ({}): they are sent no messages until they are found", robots.size(),
                 counted(info_.robots.size(), "robot"), in_words(robots));
  }

  // Looks are as often as frames, pictures may be rarer.
  bool has_picture() const { return picture_at_ && now() - *picture_at_ < 2s; }
  // What the wait at the beginning waits for.
  std::string missing() const {
    if (!controller_.is_up() && !port_.is_open())
      return port_.error().empty() ? "the overhead controller does not accept the connection" : port_.error();
    if (!controller_.is_up()) return "the overhead controller is starting";
    if (!has_picture()) return eyes_->error().empty() ? "the cameras deliver no picture" : eyes_->error();
    const std::vector<RobotId> robots = unnamed();
    if (robots.empty()) return "not every robot has been seen and identified";
    return fmt::format(
        "{} of {} robots have not been seen and identified ({}); are they in the arena, in view of the cameras and "
        "switched on, and are these their ids?{} arena.kilobot.may_miss lets the lab start without some",
        robots.size(), info_.robots.size(), in_words(robots),
        robots.size() == info_.robots.size()
            ? " Does their program include <arkmesh_id.h>? Without it a robot cannot send its id."
            : "");
  }

  void serve_controller() {
    note_pause();
    if (guard_ && guard_->takes_line()) {
      own_counters_.add("overhead.taken_by_guard");
      controller_.pause_first();
    }
    controller_.poll(now());
    serve_at_ = controller_.due(now());
    if (phase_ < Phase::stopping) begin_to_judge();  // then what was seen last stands
    tell_guard();
    if (std::exchange(was_up_, controller_.is_up()) == controller_.is_up()) return;
    if (controller_.is_up()) return spdlog::info("the overhead controller listens");
    spdlog::warn("the overhead controller is gone: {}; trying again", port_.error());
  }

  // How long the lab was away at most, for which a guard would have taken it for hung.
  void note_pause() {
    const TimePoint at = now();
    const auto away = std::chrono::duration_cast<std::chrono::milliseconds>(at - std::exchange(served_at_, at));
    if (away <= longest_away_) return;
    own_counters_.add("lab.longest_pause_ms", static_cast<std::uint64_t>((away - longest_away_).count()));
    longest_away_ = away;
  }

  std::optional<PoseFrame> look() {
    const LabTime since_made = std::chrono::duration_cast<LabTime>(now() - made_);
    looked_at_ = made_ + since_made;  // to the microsecond, as ages are
    eyes_->look(since_made);
    controller_.withhold(eyes_->doubtful(), now());
    controller_.ask(eyes_->question());
    serve_controller();
    auto frame = eyes_->latest();
    if (frame) judge_.look(*frame, looked_at_);
    judged_ = judge_.not_standing(now());
    if (phase_ > Phase::beginning) supervise();
    return frame;
  }

  bool should_stand() const {
    const auto wanted = controller_.wanted();
    return wanted && *wanted != FleetCommand::Kind::run;
  }

  // What was seen before robots had heard the word tells nothing.
  void begin_to_judge() {
    if (controller_.wanted() == FleetCommand::Kind::run) ran_until_ = now();
    eyes_->robots_run(controller_.wanted() == FleetCommand::Kind::run && controller_.said_since());
    const std::pair told{controller_.wanted(), controller_.said_since()};
    if (told == told_) return;
    told_ = told;
    judge_.begin();
    judged_ = judge_.not_standing(now());
    walkers_.clear();
  }

  // Says who does not do what all were told, once each.
  void supervise() {
    const std::vector<RobotId> moved_by_hand = judge_.take_carried();
    const std::vector<RobotId> resting = judge_.take_resting();
    if (!should_stand() && !resting.empty()) {
      // one that was switched off and on waits for everything; many programs let robots stand
      spdlog::info("{} of {} robots have not moved for a while despite the run command: {}", resting.size(),
                   info_.robots.size(), in_words(resting));
      for (const RobotId robot : resting) controller_.note_restart(robot);
    }
    if (!should_stand() || !controller_.said_since()) return;
    std::vector<RobotId> walkers, fresh, carried;
    std::ranges::set_difference(moved_by_hand, carried_, std::back_inserter(carried));
    if (!carried.empty()) spdlog::info("robots are being carried: {}", in_words(carried));
    carried_.insert(moved_by_hand.begin(), moved_by_hand.end());
    bool all_judged = true;  // of those in sight
    std::erase_if(carried_, [&](RobotId robot) { return !std::ranges::count(judged_, robot, &NotStanding::robot); });
    for (const NotStanding& robot : judged_) {
      if (robot.why == NotStanding::Why::moving) walkers.push_back(robot.robot);
      if (robot.why == NotStanding::Why::not_yet) all_judged = false;
    }
    if (!walkers.empty() || (ran_until_ && !all_judged)) controller_.urge(now());
    if (ran_until_ && judge_.most_walk_on(*ran_until_)) controller_.doubt_line();
    std::ranges::set_difference(walkers, walkers_, std::back_inserter(fresh));
    walkers_ = std::move(walkers);
    if (fresh.empty()) return;
    own_counters_.add("robots.moved_when_told_to_stand", fresh.size());
    spdlog::warn("robots move despite the stop command, which is repeated: {}", in_words(fresh));
  }

  // Towards the end. False: not yet, and there is still time.
  bool see_them_stand() {
    const TimePoint at = now();
    const bool stand = controller_.said_since() && (!ran_until_ || not_standing().empty());
    if (stand || at >= last_until_) return true;
    if (at >= wanted_at_) {
      look();
      wanted_at_ = std::min(last_until_, now() + info_.frame_period);
    }
    return false;
  }

  void tell_guard() {
    if (guard_ && phase_ < Phase::stopping)
      guard_->tell({.wanted = should_stand() ? *controller_.wanted() : FleetCommand::Kind::pause,
                    .all_stand = should_stand() && port_.is_open() && not_standing().empty(),
                    .ended = false,
                    .said = controller_.said_since().has_value()});
  }

  void make_frame(LabTime stamp) {
    if (auto frame = look()) {
      // the look was a little later than its stamp
      const auto late = std::chrono::duration_cast<LabTime>(looked_at_ - wanted_at_);
      for (Observation& robot : frame->robots) robot.age = std::max(LabTime{0}, robot.age - late);
      if (stamp - seen_at_ > blind_after) spdlog::info("the cameras see the testbed again");
      return put(std::move(*frame), stamp);
    }
    // a gap in the numbers tells those who listen
    ++frames_;
    own_counters_.add("poses.lost.no_picture");
    if (stamp - seen_at_ > blind_after && stamp - info_.frame_period - seen_at_ <= blind_after)
      spdlog::warn("the cameras have delivered no picture for {} s",
                   std::chrono::duration<double>(blind_after).count());
  }

  void put(PoseFrame frame, LabTime stamp) {
    seen_at_ = stamp;
    frame.stamp = stamp;
    frame.number = static_cast<std::uint32_t>(frames_++);
    keep_inside(frame, info_, own_counters_);
    poses_.put(std::move(frame));
  }

  WallTime& wall_;
  ArenaInfo info_;
  Patience patience_;
  std::unique_ptr<RobotMonitor> eyes_;
  Counters own_counters_;
  mutable Counters counters_;  // with those of the eyes, brought up to date when somebody looks
  OwnedClock clock_;
  NewestFrame poses_;
  Pacer pacer_;
  PacketPort port_;
  OverheadController controller_;
  Phase phase_ = Phase::beginning;
  TimePoint made_ = now();
  TimePoint wanted_at_ = TimePoint::max();  // when the call that was answered with false has something to do again
  TimePoint serve_at_ = made_;              // when the controller has
  TimePoint served_at_ = made_;
  std::chrono::milliseconds longest_away_{0};  // between two calls that served the controller
  TimePoint looked_at_{};
  std::optional<TimePoint> picture_at_;  // the last look while beginning that gave a frame
  StandJudge judge_;
  std::shared_ptr<StandGuard> guard_;                                            // null: none
  std::pair<std::optional<FleetCommand::Kind>, std::optional<TimePoint>> told_;  // what is judged, and since when
  std::optional<TimePoint> begun_at_, ran_until_;  // the first advance_to; robots were wanted to run, last
  bool was_up_ = false;
  std::vector<RobotId> walkers_;     // as last said
  std::set<RobotId> carried_;        // likewise, until they stand
  TimePoint last_until_{};           // of the ending
  std::vector<NotStanding> judged_;  // at the last look: whoever asks between looks learns nothing newer
  std::int64_t frames_ = 0;          // made or lost so far; also the next one's number
  LabTime seen_at_{0};               // stamp of the last frame that was made
};

}  // namespace

std::unique_ptr<ByteStream> open_byte_stream(const std::string& port, const std::string& lab,
                                             std::shared_ptr<StandGuard> guard) {
  std::shared_ptr<PortLock> lock;
  std::unique_ptr<ByteStream> stream = claim_byte_stream(port, "lab " + lab, &lock, std::move(guard));
  stream->open();
  if (stream->check() == ByteStream::State::closed) throw PortError(stream->error() + lock->guarded_words());
  return stream;
}

std::unique_ptr<Arena> make_kilobot_arena(ArenaSettings settings, std::unique_ptr<RobotMonitor> eyes,
                                          std::unique_ptr<ByteStream> stream, std::shared_ptr<StandGuard> guard,
                                          WallTime& wall) {
  const KilobotArena::Patience patience{settings.names_within, settings.may_miss};
  return std::make_unique<KilobotArena>(std::move(settings.info), settings.overhead, patience, std::move(stream),
                                        std::move(eyes), std::move(guard), wall);
}

}  // namespace arkmesh::hal::kilobot
