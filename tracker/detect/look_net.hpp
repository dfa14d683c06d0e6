// A small net that was trained to look closely at one circle: is that a robot? tracker/training/ says how it came to
// be.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "tracker/detect/circle.hpp"

namespace arkmesh::tracker {

class LookNet {
 public:
  LookNet();
  ~LookNet();
  LookNet(LookNet&&) noexcept;
  LookNet& operator=(LookNet&&) noexcept;

  // How surely each circle of an 8-bit BGR picture is a robot's edge, 0..1, in the order of the circles: a probability
  // in the rooms of tracker/training/. One whose radius is off by a quarter, as a coin cell's, is none.
  std::vector<double> look_at(const cv::Mat& bgr, const std::vector<Circle>& circles);

 private:
  struct Net;
  std::unique_ptr<Net> net_;
};

}  // namespace arkmesh::tracker
