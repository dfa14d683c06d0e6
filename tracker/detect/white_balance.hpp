// A false white balance, as the robots of a picture and their arena show it together: what is tinted alone has that
// colour itself.
#pragma once

#include <span>

#include "tracker/detect/circle.hpp"
#include "tracker/detect/led_colour.hpp"

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

// A channel brighter than this may be cut off: it says only how bright the light is at least.
inline constexpr int most_certain = 250;

// Factors that make light what it was, 1 where nothing is false. `boards` are the circles round the robots of an 8-bit
// BGR picture.
Light white_balance(const cv::Mat& bgr, std::span<const Circle> boards);

// Whether a picture has no colour where its robots are: a monochrome camera's.
bool monochrome(const cv::Mat& bgr, std::span<const Circle> boards);

}  // namespace arkmesh::tracker
