// One robot as all cameras together saw it in one frame, on the arena plane. No history.
#pragma once

#include <optional>

#include "hal/types.hpp"

namespace arkmesh::tracker {

struct FusedObservation {
  double x_m = 0, y_m = 0;  // arena frame, the robot's centre
  double sigma_m = 0.0007;  // standard deviation of each coordinate
  float confidence = 0;     // 0..1 that this is a robot
  hal::Led led = hal::Led::off;
  float led_confidence = 0;          // 0..1 that the colour is right; 0 when nothing of the LED could be seen
  hal::Led primary = hal::Led::off;  // what an LED that is known to show red, green or blue shows
  float primary_confidence = 0;      // 0..1, as that of Detection
  std::optional<double>
      led_heading_rad;  // direction from the centre to the LED, counter-clockwise from +x; empty when the LED is off
  double led_heading_sigma_rad = 0.1;  // its standard deviation
};

}  // namespace arkmesh::tracker
