// Landmarks of an arena in one picture: corners, specks, edges of what lies about, by which another picture shows
// whether the camera still hangs where it did. Small enough for a calibration file to keep them.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "tracker/camera/calibration.hpp"
#include "tracker/detect/detection.hpp"

namespace arkmesh::tracker {

struct Landmark {
  static constexpr int side = 23;        // pixels of `grey`, which is centred on the landmark
  static constexpr int rough_side = 17;  // pixels of `rough`, each rough_block(width) wide in the picture

  int x_px = 0, y_px = 0;
  // Row by row. `rough` is of the downsampled image, and what is near it where the picture ends.
  std::vector<std::uint8_t> grey, rough;
};

// Landmarks are looked for from afar in pictures that are smaller by this factor, about 480 pixels wide.
int rough_block(int width_px);
cv::Mat downsampled_grey(const cv::Mat& bgr, int by);
// Where a landmark's rough patch lies in a downsampled image of that size. The picture is larger than the patch.
cv::Rect rough_patch(int x_px, int y_px, int by, const cv::Size& of);

inline float grey_of(const cv::Vec3b& pixel) {
  return 0.25F * static_cast<float>(pixel[0] + 2 * pixel[1] + pixel[2]);
}

// What a landmark is compared by: its grey levels without their mean, their slopes, and the slopes' products. Levels
// are smoothed by the weights 1, 2, 1 along and across, or else in the noise of a dim room few landmarks are alike in
// two pictures.
struct Template {
  static constexpr int side = Landmark::side - 4;
  std::vector<float> grey, along_x, along_y;
  double energy = 0, xx = 0, xy = 0, yy = 0;
};
Template template_of(const Landmark& landmark);

// At most 40, well spread, those first whose place is known best; where `robots` are there are none. The picture is
// 8-bit BGR, of the size that the calibration is for.
std::vector<Landmark> find_landmarks(const cv::Mat& bgr, std::span<const Detection> robots,
                                     const Calibration& calibration);

}  // namespace arkmesh::tracker
