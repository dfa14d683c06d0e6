// The LED of one robot: the brightest small spot near its edge, whether it is lit at all, and the colour of the light
// round it.
#pragma once

#include "hal/types.hpp"
#include "tracker/detect/circle.hpp"
#include "tracker/detect/led_colour.hpp"

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

struct LedSpot {
  hal::Led led = hal::Led::off;  // unknown: hardly darker than a lit one, or light where no LED is
  float confidence = 0;       // 0..1 that `led` is right; 0 when the place where an LED could be is not in the picture
  float lit_confidence = 0;   // 0..1 that it is lit, or that it is off
  double hue_deg = 0;         // as LedColour's; 0 when off
  double x_px = 0, y_px = 0;  // centre of the bright core; not a number when off or unknown
  // Of red, green and blue the one that the brightest spot adds most of, whether it is held for lit or not: for robots
  // that are known to show one of these. Off when there is no such light at all.
  hal::Led primary = hal::Led::off;
  float primary_confidence = 0;  // 0..1: share by which it outshines the second
};

// `board` is the circle round the robot's outer edge in an 8-bit BGR picture.
// `gains`: see white_balance().
LedSpot find_led(const cv::Mat& bgr, const Circle& board, const Light& gains = {1, 1, 1});

}  // namespace arkmesh::tracker
