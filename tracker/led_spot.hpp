// The LED of one robot: the brightest small spot near its rim, whether it is lit at all, and the colour of the light round it.
#pragma once

#include "hal/types.hpp"
#include "tracker/circle.hpp"

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

struct LedSpot {
  hal::Led led = hal::Led::off;
  float confidence = 0;          // 0..1 that `led` is right; 0 when the place where an LED could be is not in the picture
  double x_px = 0, y_px = 0;     // centre of the bright core; not a number when off
};

// `board` is the circle round the robot's outer edge in an 8-bit BGR picture.
LedSpot find_led(const cv::Mat& bgr, const Circle& board);

}  // namespace arkmesh::tracker
