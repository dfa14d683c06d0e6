// How many robots are near a robot, of its own lab and of others, by what their LEDs show.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::scenarios::kit {

struct Seen {
  hal::Point place;  // all in one frame
  hal::Led led = hal::Led::off;
};

// A set of LEDs: bit n stands for the LED n of hal::Led.
using LedSet = std::uint16_t;
inline constexpr LedSet any_led = 0x1ff;  // unknown ones, too
constexpr LedSet only(hal::Led led) {
  return static_cast<LedSet>(1U << static_cast<unsigned>(led));
}

// For each of `robots`, with which `all` begins, how many others of `all` with such an LED are within `range_m` of it.
// Time grows with robots and neighbours, not with pairs. Throws std::invalid_argument for a range that is none.
std::vector<int> neighbours(std::span<const Seen> robots, std::span<const Seen> all, double range_m,
                            LedSet leds = any_led);
// Each pair of one of `robots` and one of `all` within range, by their numbers, itself included where it is in both: in
// the order of `robots`, and for each of them in a fixed one.
void each_near(std::span<const Seen> robots, std::span<const Seen> all, double range_m,
               const std::function<void(std::size_t robot, std::size_t other)>& visit);
// The share of robots with such an LED; 0 of none.
double share(std::span<const Seen> robots, LedSet leds);

}  // namespace arkmesh::scenarios::kit
