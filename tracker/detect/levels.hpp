// Which grey levels a picture uses. Through haze, or much too dark, it is few of them, and all edges are weak.
#pragma once

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

struct Levels {
  double black = 0, gain = 1;  // what makes all levels of the few; a gain of 1 where there are not few
};

// Of an 8-bit BGR picture without its margin, where cameras write the time.
Levels levels_of(const cv::Mat& bgr);
cv::Mat stretched(const cv::Mat& bgr, const Levels& levels);

}  // namespace arkmesh::tracker
