// The LEDs of all robots over time, within a tick too.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "hal/types.hpp"
#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {

class LedLights {
 public:
  explicit LedLights(int robots)
      : colours_(static_cast<std::size_t>(robots), 0), moments_(static_cast<std::size_t>(robots), 0) {}

  // A kilolib colour (2 bits each: red, green, blue) from `us` after the start of the present tick on.
  void set(int robot, std::uint8_t colour, std::int64_t us) {
    if (us == 0)
      begin({robot, 0, colour});
    else
      changes_.push_back({robot, us, colour});
  }
  // Dark for the whole tick, whatever was to be shown in it.
  void put_out(int robot) {
    std::erase_if(changes_, [robot](const Change& change) { return change.robot == robot; });
    set(robot, 0, 0);
  }
  std::uint8_t colour(int robot) const { return colours_[static_cast<std::size_t>(robot)]; }
  // The sum of its colours' steps, 0..9, integrated over time up to the start of the present tick.
  std::int64_t steps_us(int robot) const {
    return steps(colour(robot)) * tick_start_us_ - moments_[static_cast<std::size_t>(robot)];
  }
  // The tick is over.
  void end_tick() {
    for (const Change& change : changes_) begin(change);
    changes_.clear();
    tick_start_us_ += tick_us;
  }
  // Mean light from `from_us` to `to_us` of the present tick, red, green and blue of 0..3; the colour at `to_us` when
  // both are one.
  void gather(std::int64_t from_us, std::int64_t to_us, std::vector<std::array<float, 3>>& out) const {
    out.resize(colours_.size());
    const auto parts = [](std::uint8_t colour) {
      return std::array<float, 3>{static_cast<float>(colour & 3), static_cast<float>(colour >> 2 & 3),
                                  static_cast<float>(colour >> 4 & 3)};
    };
    for (std::size_t i = 0; i < colours_.size(); ++i) out[i] = parts(colours_[i]);
    // each change holds from its moment on: move the mean by what is left of the span
    std::vector<std::uint8_t> last;
    if (!changes_.empty()) last = colours_;
    for (const Change& change : changes_) {
      if (change.us > to_us) continue;
      const auto i = static_cast<std::size_t>(change.robot);
      const float share = to_us > from_us ? static_cast<float>(to_us - std::max(from_us, change.us)) /
                                                static_cast<float>(to_us - from_us)
                                          : 1;
      const std::array<float, 3> before = parts(last[i]), after = parts(change.colour);
      for (std::size_t c = 0; c < 3; ++c) out[i][c] += share * (after[c] - before[c]);
      last[i] = change.colour;
    }
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
  static int steps(int colour) { return (colour & 3) + (colour >> 2 & 3) + (colour >> 4 & 3); }
  void begin(const Change& change) {
    const auto i = static_cast<std::size_t>(change.robot);
    moments_[i] += (steps(change.colour) - steps(colours_[i])) * (tick_start_us_ + change.us);
    colours_[i] = change.colour;
  }
  static hal::Led seen(std::uint8_t colour) {
    return static_cast<hal::Led>((colour & 0x03 ? 1 : 0) | (colour & 0x0C ? 2 : 0) | (colour & 0x30 ? 4 : 0));
  }

  std::vector<std::uint8_t> colours_;
  std::vector<Change> changes_;
  std::vector<std::int64_t> moments_;  // by robot: sum of the changes of its steps, each times when it came
  std::int64_t tick_start_us_ = 0;
};

}  // namespace arkmesh::sim_ode
