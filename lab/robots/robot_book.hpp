// What each robot of the lab needs to know, and who owns that: whether to run, start parameters, and words until shown
// (RobotWords). The experiment, its scenario, operators, safety and lost peers each say what they want; robots run only
// if it has begun and nobody wants otherwise. Whatever changes is told to the arena and to the bus; what robots may
// have missed or forgotten is told again. Single-threaded.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/bus/bus.hpp"
#include "hal/counters.hpp"
#include "hal/types.hpp"
#include "lab/robots/robot_words.hpp"

namespace arkmesh::lab {

class RobotBook {
 public:
  using Kind = hal::FleetCommand::Kind;
  // Who may want robots to stand. Of several the first is named.
  enum class Who { operators, safety, lost_peer, scenario };
  // Within the experiment. What stands at its end stays open.
  struct Pause {
    std::string who;
    hal::LabTime from{0};
    std::optional<hal::LabTime> until;  // none: it stands, or stood at the end
  };

  // All outlive it. `absent`: who was out of sight for so long may have been switched off, or out of reach.
  RobotBook(hal::Arena& arena, hal::Bus& private_bus, RobotWords& words, hal::LabTime absent)
      : arena_(arena), bus_(private_bus), words_(words), absent_(absent) {}
  RobotBook(const RobotBook&) = delete;

  // From now on robots run, unless somebody wants otherwise.
  void begin(hal::LabTime now);
  // For good: robots stand, or go on sleeping, charging or showing their voltage.
  void end(hal::LabTime now);
  // What somebody says: the newest word of each counts until the next; `run` gives way to all others. A reset is done
  // at once and keeps robots still until the same one says `run`. `name`: in whose name, for people.
  void say(Who who, const hal::FleetCommand& command, hal::LabTime now, std::string_view name = {});

  // Start parameters: said to all robots, over and over, before they run for the first time, since a reset, since the
  // parameters changed or since one of them may not have gone out. Those of a type replace all former ones of that
  // type. What are more than 64 in all is refused and counted.
  void prepare(std::span<const hal::WholeMessage> parameters);

  // A frame of an arena that keeps real time: robots seen again after so long lack what they were told.
  void see(const hal::PoseFrame& frame);
  // Tells again what did not go out, and all of it after the line was opened or when somebody lacks it: parameters,
  // `run` and words to robots that run, at most every 5 s; the arena itself keeps others still. Call it often. Counts
  // `robots.seen_again`, `robots.restarted`, `to_robots.told_again`, `parameters.told_again`, `run.told_again`.
  void catch_up(hal::LabTime now);

  // What robots should do now.
  Kind wanted() const;
  // Who keeps them from running: "operator", "safety", "lost peer", "scenario", "not begun", "end"; empty: nobody.
  std::string kept_still_by() const;
  // Somebody does, other than that the experiment has not begun or is over.
  bool is_paused() const { return begun_ && !ended_ && wanted() != Kind::run; }
  const std::vector<Pause>& pauses() const { return pauses_; }
  hal::Counters counters() const;
  // Messages that it takes to tell all robots everything anew, as after a reset: words, and start parameters.
  std::size_t words_anew() const { return words_.size() * RobotWords::for_sure; }
  std::size_t parameters_anew() const { return parameters_.size() * start_rounds; }

 private:
  // Of parameters: an arena may say a broadcast once, and a robot may miss every tenth message.
  static constexpr int start_rounds = 4;
  struct Wish {
    Kind kind = Kind::run;
    std::string name;
  };
  void tell(const hal::FleetCommand& command, hal::LabTime now);
  void tell_parameters(int rounds, hal::LabTime now);
  void doubt(hal::RobotId robot);
  void update(hal::LabTime now);
  void keep_records(hal::LabTime now);

  hal::Arena& arena_;
  hal::Bus& bus_;
  RobotWords& words_;
  const hal::LabTime absent_;
  std::array<Wish, 4> wishes_{Wish{Kind::run, "operator"}, Wish{Kind::run, "safety"}, Wish{Kind::run, "lost peer"},
                              Wish{Kind::run, "scenario"}};  // by Who
  bool begun_ = false, ended_ = false;
  Kind told_ = Kind::pause;                    // robots that nobody has told anything stand
  std::vector<hal::WholeMessage> parameters_;  // by type
  bool parameters_due_ = true;
  bool reset_ = false;  // since robots ran last
  bool lack_ = false;   // robots that run may lack what they were told
  hal::LabTime lack_told_{hal::LabTime::min() / 2};
  std::uint64_t openings_ = 0;
  std::map<hal::RobotId, hal::LabTime> seen_;         // last
  std::array<std::optional<std::size_t>, 4> open_{};  // by Who: of pauses_
  std::vector<Pause> pauses_;
  hal::Counters counters_;
};

}  // namespace arkmesh::lab
