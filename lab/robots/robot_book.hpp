// Whether the lab's robots run: the one owner of that fact. The experiment, its scenario, operators, safety and lost
// peers each say what they want; robots run only if it has begun and nobody wants otherwise. Whatever changes is told
// to the arena, which sees to it that robots do it, and to the bus. Single-threaded.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/arena.hpp"
#include "hal/bus.hpp"
#include "hal/counters.hpp"
#include "hal/types.hpp"

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

  // Both outlive it.
  RobotBook(hal::Arena& arena, hal::Bus& private_bus) : arena_(arena), bus_(private_bus) {}
  RobotBook(const RobotBook&) = delete;

  // From now on robots run, unless somebody wants otherwise.
  void begin(hal::LabTime now);
  // For good: robots stand, or go on sleeping, charging or showing their voltage.
  void end(hal::LabTime now);
  // What somebody says: the newest word of each counts until the next; `run` gives way to all others. A reset is done
  // at once and keeps robots still until the same one says `run`. `name`: in whose name, for people.
  void say(Who who, const hal::FleetCommand& command, hal::LabTime now, std::string_view name = {});

  // Start parameters: said to all robots, over and over, before they run for the first time, since a reset or since the
  // parameters changed. The newest of a type replaces the former. What is one type too many is refused and counted.
  void prepare(const hal::WholeMessage& parameters);

  // What robots should do now.
  Kind wanted() const;
  // Who keeps them from running: "operator", "safety", "lost peer", "scenario", "not begun", "end"; empty: nobody.
  std::string kept_still_by() const;
  // Somebody does, other than that the experiment has not begun or is over.
  bool is_paused() const { return begun_ && !ended_ && wanted() != Kind::run; }
  const std::vector<Pause>& pauses() const { return pauses_; }
  const hal::Counters& counters() const { return counters_; }

 private:
  struct Wish {
    Kind kind = Kind::run;
    std::string name;
  };
  void tell(const hal::FleetCommand& command, hal::LabTime now);
  void tell_parameters(hal::LabTime now);
  void update(hal::LabTime now);
  void keep_records(hal::LabTime now);

  hal::Arena& arena_;
  hal::Bus& bus_;
  std::array<Wish, 4> wishes_{Wish{Kind::run, "operator"}, Wish{Kind::run, "safety"}, Wish{Kind::run, "lost peer"},
                              Wish{Kind::run, "scenario"}};  // by Who
  bool begun_ = false, ended_ = false;
  Kind told_ = Kind::pause;                                         // robots that nobody has told anything stand
  std::map<std::uint8_t, std::array<std::uint8_t, 9>> parameters_;  // by type
  bool parameters_due_ = true;
  std::array<std::optional<std::size_t>, 4> open_{};  // by Who: of pauses_
  std::vector<Pause> pauses_;
  hal::Counters counters_;
};

}  // namespace arkmesh::lab
