// The LEDs of all robots over time, within a tick too.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::sim_ode {

class LedLights {
 public:
  explicit LedLights(int robots) : colours_(static_cast<std::size_t>(robots), 0) {}

  // A kilolib colour (2 bits each: red, green, blue) from `us` after the start of the present tick on.
  void set(int robot, std::uint8_t colour, std::int64_t us) {
    if (us == 0) colours_[static_cast<std::size_t>(robot)] = colour;
    else changes_.push_back({robot, us, colour});
  }
  // The tick is over.
  void end_tick() {
    for (const Change& change : changes_) colours_[static_cast<std::size_t>(change.robot)] = change.colour;
    changes_.clear();
  }
  // What a camera sees `us` after the start of the present tick: one of eight colours per robot.
  void look(std::int64_t us, std::vector<hal::Led>& out) const {
    out.resize(colours_.size());
    for (std::size_t i = 0; i < colours_.size(); ++i) out[i] = seen(colours_[i]);
    for (const Change& change : changes_)  // in time order for each robot
      if (change.us <= us) out[static_cast<std::size_t>(change.robot)] = seen(change.colour);
  }

 private:
  struct Change {
    int robot;
    std::int64_t us;
    std::uint8_t colour;
  };
  static hal::Led seen(std::uint8_t colour) {
    return static_cast<hal::Led>((colour & 0x03 ? 1 : 0) | (colour & 0x0C ? 2 : 0) | (colour & 0x30 ? 4 : 0));
  }

  std::vector<std::uint8_t> colours_;
  std::vector<Change> changes_;
};

}  // namespace arkmesh::sim_ode
