// Decides what a robot has to be told, and when: at once when it changes; again, at a low rate, while the robot's LED
// does not show that it heard, or while a wall is near. Airtime is scarce, so a robot that knows is left alone.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

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
};

// The message for a robot at `place` that shows `led`.
Told message_for(const Place& place, hal::Led led);

class RobotMessages {
 public:
  explicit RobotMessages(hal::LabTime repeat) : repeat_(repeat) {}
  // The message to send now, if any.
  std::optional<hal::ToRobot> next(hal::LabTime now, hal::RobotId robot, const Place& place, hal::Led led);

 private:
  struct Last {
    Told told;  // as booted: outside, no wall
    hal::LabTime when{0};
  };
  hal::LabTime repeat_;
  std::vector<Last> last_;  // by robot id
};

}  // namespace arkmesh::scenarios::dhtf
