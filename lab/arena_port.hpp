// A lab's arena on the lab's private bus. A pose passes here once on its way out (arena -> bus, and to the caller), and
// what is said to single robots once on its way back (bus and arena); what is said to all of them passes RobotBook.
// The bus has it for the recorder and the tap; nothing is decoded again from it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/bus/bus.hpp"
#include "hal/counters.hpp"
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
  // What a scenario answers to frame `frame` at lab time `now`, as one batch.
  void say(std::span<const hal::ToRobot> messages, hal::LabTime now, std::uint32_t frame);

  // Everything dropped, replaced or refused inside the arena ("arena.").
  hal::Counters counters() const;

 private:
  hal::Arena& arena_;
  hal::Bus& bus_;
};

}  // namespace arkmesh::lab
