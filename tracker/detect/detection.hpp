// What one look at one picture finds: round robot bodies and their LEDs, in pixels. No ids, no arena.
#pragma once

#include "hal/types.hpp"

namespace arkmesh::tracker {

// Pixels: x to the right, y down, the centre of the top-left pixel is (0, 0).
struct Detection {
  double x_px = 0, y_px = 0;  // centre of the circle round the outer edge of the robot's board
  double r_px = 0;            // its radius
  float confidence = 0;       // 0..1 that this is a robot
  hal::Led led = hal::Led::off;
  float led_confidence = 0;           // 0..1 that the colour is right; 0 says nothing about the LED could be seen
  float led_lit_confidence = 0;       // 0..1 that it is lit or not, as `led` says
  double led_hue_deg = 0;             // of its light, [-25, 335); 0 when it has none
  double led_x_px = 0, led_y_px = 0;  // centre of the bright core; not a number when the LED is off or unknown
  hal::Led primary = hal::Led::off;   // what an LED that is known to show red, green or blue shows: see LedSpot
  float primary_confidence = 0;
};

}  // namespace arkmesh::tracker
