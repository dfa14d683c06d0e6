// The way to robots that speak Aseba: words as events in turn, the state of the fleet over and over, and whether the
// robots' wheels stand, which they are asked.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/platforms/aseba/nodes.hpp"

namespace arkmesh::hal::aseba {

// A clause for people.
inline constexpr const char* runs_no_guard = "run no program that stops their wheels when the lab is gone";

class AsebaLink final : public RobotLink {
 public:
  static constexpr std::chrono::milliseconds forced_after{500};  // a program that drives on is halted
  static constexpr std::chrono::seconds unguarded_after{5};      // a robot whose program does not answer

  // All outlive the link. `words_per_s`: to all robots together.
  AsebaLink(const ArenaInfo& info, Nodes& nodes, double words_per_s, Counters& counters)
      : info_(info),
        nodes_(nodes),
        word_each_(std::chrono::microseconds(static_cast<int>(1e6 / words_per_s))),
        counters_(counters) {}

  void offer(std::span<const ToRobot> newest) override;
  Airtime airtime() const override;
  void command(const FleetCommand& command) override;
  NotHeard not_heard() override;
  std::vector<FromRobot> heard() override { return std::exchange(heard_, {}); }

  // For the arena.
  // Whether robots are told what was offered and commanded; until then they stand.
  void release() { released_ = true; }
  // Serves the nodes and what waits for them. Never blocks.
  void poll(TimePoint now);
  // Drops what waits for single robots; robots stand from now on.
  void finish();
  bool should_stand() const { return !released_ || wanted_ != FleetCommand::Kind::run; }
  // When robots that should stand were told so first.
  std::optional<TimePoint> told_since() const { return told_since_; }
  // Robots that should stand, and have not said that their wheels do since they were told. Ascending.
  std::vector<NotStanding> not_standing() const;
  // What the robot's program says that its LED shows. Unknown: it says nothing.
  Led led(RobotId robot) const;

 private:
  struct Waiting {
    ToRobot message;
    TimePoint since;
  };
  using Register = std::pair<RobotId, std::uint8_t>;
  void send_words(TimePoint now);
  void take_events();
  void tell_state(TimePoint now);
  void see_to(RobotId robot, TimePoint now);
  void watch_programs(TimePoint now);

  const ArenaInfo& info_;
  Nodes& nodes_;
  const std::chrono::microseconds word_each_;
  Counters& counters_;
  std::map<Register, Waiting> words_;
  std::deque<Register> order_;
  Airtime airtime_;
  TimePoint now_{}, next_word_{}, beat_at_{};
  FleetCommand::Kind wanted_ = FleetCommand::Kind::pause;
  bool released_ = false, reset_ = false;
  std::optional<bool> said_stand_;
  std::optional<TimePoint> told_since_;
  struct Told {
    TimePoint at, said, asked, first;  // at: when it was known to drive last
    bool forced = false;
  };
  std::map<RobotId, Told> told_;  // to stand
  struct Program {
    TimePoint heard_at;
    Led led = Led::unknown;
    bool unguarded = false;
  };
  std::map<RobotId, Program> programs_;  // of robots that are there
  std::set<RobotId> given_up_;
  std::map<RobotId, SetPoint> set_points_;  // in force while robots run
  std::vector<FromRobot> heard_;
};

}  // namespace arkmesh::hal::aseba
