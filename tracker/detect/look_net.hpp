// A small trained net that examines one circle closely: is it a robot's edge? tracker/training/ says how it was
// trained.
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

  // For each circle of an 8-bit BGR picture, in their order, the probability that it is a robot's edge, as it is in the
  // rooms of tracker/training/. Circles whose radius is off by a quarter or more, such as a coin cell's, are not.
  std::vector<double> probabilities(const cv::Mat& bgr, const std::vector<Circle>& circles);

 private:
  struct Net;
  std::unique_ptr<Net> net_;
};

}  // namespace arkmesh::tracker
