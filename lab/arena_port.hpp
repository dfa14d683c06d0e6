// A lab's arena on the lab's private bus. A pose passes here once on its way out (arena -> bus, and to the caller), and
// what is said to robots once on its way back (bus and arena). The bus has it for the recorder and the tap; nothing is
// decoded again from it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/arena.hpp"
#include "hal/bus.hpp"
#include "hal/counters.hpp"
#include "hal/messages.hpp"
#include "hal/types.hpp"

namespace arkmesh::lab {

class ArenaPort {
 public:
  // Both outlive the port.
  ArenaPort(hal::Arena& arena, hal::Bus& private_bus);
  ArenaPort(const ArenaPort&) = delete;

  // What the arena has had to tell since the last call: published, and handed over.
  struct Snapshot {
    std::vector<hal::FromRobot> heard;
    std::optional<hal::PoseFrame> frame;
  };
  Snapshot take_snapshot();
  void publish_info();
  // What a scenario answers to frame `frame` at lab time `now`, as one batch each. Commands that no platform knows are
  // refused and counted.
  void say(std::span<const hal::ToRobot> messages, std::span<const hal::FleetCommand> commands, hal::LabTime now,
           std::uint32_t frame);
  // A command of the scenario or of an operator. What operators say is no part of a reproducible run.
  void obey(const fleet_command_t& command);
  // Nobody makes robots run that are kept still. Afterwards they do what a scenario or an operator said last, meanwhile
  // or before.
  void keep_still(bool still, hal::LabTime now);
  // What a scenario or an operator said last is to run.
  bool told_to_run() const { return told_to_run_; }
  // Robots stop. Nobody may make them run afterwards.
  void pause_for_good(hal::LabTime now, std::uint32_t frame);

  // Everything dropped, replaced or refused on the way, and inside the arena ("arena.").
  hal::Counters counters() const;

 private:
  hal::Arena& arena_;
  hal::Bus& bus_;
  hal::Counters counters_;
  bool still_ = false, told_to_run_ = false;
};

}  // namespace arkmesh::lab
