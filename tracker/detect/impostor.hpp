// Round things that are no robots, known by what circles drawn inside and outside their edge show: holes and
// pads of circuit boards.
#pragma once

#include "tracker/detect/circle_fit.hpp"

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

// Why the thing within the edge cannot be a robot, for an explanation; null where it may be one.
const char* why_no_robot(const cv::Mat& bgr, const CircleFit& circle_fit);

}  // namespace arkmesh::tracker
