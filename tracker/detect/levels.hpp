// The grey levels that a picture uses. In haze, or in little light, they are few, and all edges are weak.
#pragma once

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

struct Levels {
  double black = 0, gain = 1;  // new level = gain (level - black); a gain of 1: they are not few
};

// Of an 8-bit BGR picture without its margin, where cameras write the time.
Levels levels_of(const cv::Mat& bgr);
cv::Mat stretched(const cv::Mat& bgr, const Levels& levels);

}  // namespace arkmesh::tracker
