// The table of what a robot has to be told, for Lab::tell: by where it is, and by what its LED shows.
#pragma once

#include <cstdint>

#include "hal/types.hpp"

namespace arkmesh::scenarios::dhtf {

// What a robot shows of its state.
inline constexpr hal::Led walking = hal::Led::blue, dwelling = hal::Led::green, leaving = hal::Led::red;

// Where a robot is.
struct Place {
  bool in_site = false;
  bool active = false;  // the site it is in
  int timeout_s = 0;    // of that site
  std::uint8_t wall_sectors = 0;
};

struct Told {
  std::uint8_t kind = 0;
  std::uint16_t value = 0;
  bool shown = false;  // it shows that it heard, and no wall is near
};

// The message for a robot at `place` that shows `led`.
Told message_for(const Place& place, hal::Led led);

}  // namespace arkmesh::scenarios::dhtf
