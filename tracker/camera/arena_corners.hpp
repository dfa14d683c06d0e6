// Finds the arena's corners in a picture where it stands out, lighter or darker, from what is round it.
#pragma once

#include <vector>

#include "tracker/camera/calibration.hpp"

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

// From the upper left one clockwise as the picture shows them; empty when no four-sided shape fills at least a tenth of
// the picture.
std::vector<Point> find_arena_corners(const cv::Mat& picture);

}  // namespace arkmesh::tracker
