// A part of a picture as grey levels, made smaller by averaging whole blocks of pixels: what every stage of the
// detector looks at. Grey is the brightest channel, so that a robot's black board stands out on arenas of any colour.
#pragma once

#include <cstdint>
#include <vector>

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

// Grey pixel (x, y) is the mean of block x block pixels of the picture; its centre lies at picture_x(x), picture_y(y).
struct DownsampledImage {
  int width = 0, height = 0;
  int block = 1;
  int left = 0, top = 0;           // of the part, in pixels of the picture
  std::vector<std::int16_t> grey;  // row by row; brightest channel, 8 steps to a level (0..2040)

  double picture_x(double x) const { return left + (x + 0.5) * block - 0.5; }
  double picture_y(double y) const { return top + (y + 0.5) * block - 0.5; }
  double image_x(double x_px) const { return (x_px - left + 0.5) / block - 0.5; }
  double image_y(double y_px) const { return (y_px - top + 0.5) / block - 0.5; }
  const std::int16_t* row(int y) const {
    return grey.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
  }

  // Grey level between pixels, 0..255; 0 <= x <= width - 1.001, y likewise.
  float at(float x, float y) const {
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
    const std::int16_t* upper = row(iy) + ix;
    const std::int16_t* lower = upper + width;
    const float top_row = static_cast<float>(upper[0]) + fx * static_cast<float>(upper[1] - upper[0]);
    const float bottom_row = static_cast<float>(lower[0]) + fx * static_cast<float>(lower[1] - lower[0]);
    return (top_row + fy * (bottom_row - top_row)) * 0.125F;
  }

  // Takes the part [left, right) x [top, bottom) of an 8-bit BGR picture, cut to the picture; an incomplete block at
  // the right or bottom edge is left out. Keeps its memory from call to call.
  void take(const cv::Mat& bgr, int from_x, int from_y, int to_x, int to_y, int block_px);

 private:
  std::vector<std::uint16_t> sums_;
};

// Standard deviation of the pixel noise of an 8-bit BGR picture, in grey levels, from a sample of its rows.
double noise_of(const cv::Mat& bgr);

}  // namespace arkmesh::tracker
