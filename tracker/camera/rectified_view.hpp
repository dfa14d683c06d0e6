// A camera that looks aslant, as if it looked straight down from the same place through a perfect lens: there robots
// are round and of one size wherever they are. Costs about 10 ms a picture of 3 megapixels, so only cameras that need
// it have one.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "tracker/camera/calibration.hpp"
#include "tracker/detect/detection.hpp"

namespace arkmesh::tracker {

class RectifiedView {
 public:
  // Nothing for a camera in whose pictures robots, their boards at that height, are nearly round all over the arena.
  static std::optional<RectifiedView> of(const Calibration& camera, double board_m);

  // What the camera would see; valid until the next call. Places that it does not see show the nearest that it does.
  const cv::Mat& turn(const cv::Mat& picture);
  const Calibration& calibration() const { return straight_; }
  // Back into the pixels of the camera itself. Leaves out what is cut by the edge of its picture.
  std::vector<Detection> in_camera(std::span<const Detection> detections) const;

 private:
  RectifiedView(Calibration camera, Calibration straight, double board_m);

  Calibration camera_, straight_;
  double board_m_;
  cv::Mat places_, parts_;  // where each pixel comes from, and its fraction
  cv::Mat turned_;
};

}  // namespace arkmesh::tracker
