// One robot followed through the frames of an arena, whoever it is. Made by the associator; named by the identifier.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/types.hpp"

namespace arkmesh::tracker {

using TrackNumber = std::uint32_t;  // from 0, never used twice in a run

struct Track {
  TrackNumber number = 0;
  hal::Pose in_arena;                       // heading is the driving direction
  hal::Led led = hal::Led::off;             // as last seen with certainty; unknown when it could not be told for 1 s
  bool led_seen = false;                    // in this very frame
  std::optional<double> led_direction_rad;  // as it was seen in this very frame, from the centre to the LED
  hal::Led primary =
      hal::Led::off;  // red, green or blue: what the LED shows in this frame if it is known to show one of these
  float primary_confidence = 0;          // 0..1 that it is this one; 0 when nothing of the LED was seen in this frame
  float confidence = 0;                  // 0..1 that a robot is there
  float heading_sigma_rad = 3.1415927f;  // standard deviation of the heading; pi when it is not known at all
  float heading_noise_rad = 3.1415927f;  // the same without where its LED may be, which does not change
  hal::LabTime age{0};                   // since it was last truly seen
  std::optional<hal::RobotId> robot;     // who it is, once known
  bool doubtful = false;  // may have been swapped with another or be somebody else: nobody acts on `robot`
};

}  // namespace arkmesh::tracker
