// See levels.hpp.
#include "tracker/detect/levels.hpp"

#include <algorithm>
#include <array>
#include <opencv2/core.hpp>

namespace arkmesh::tracker {

Levels levels_of(const cv::Mat& bgr) {
  constexpr int every = 2, dark_pixels = 20;  // a quarter of the smallest robot's, of those looked at
  constexpr int few = 110;
  constexpr double bright = 0.005, all = 235, most_gain = 5;
  std::array<int, 256> darkest{}, brightest{};
  int total = 0;
  for (int y = bgr.rows / 20; y < bgr.rows - bgr.rows / 20; y += every)
    for (int x = bgr.cols / 20; x < bgr.cols - bgr.cols / 20; x += every, ++total) {
      const std::uint8_t* const pixel = bgr.ptr<std::uint8_t>(y) + 3 * static_cast<std::ptrdiff_t>(x);
      const auto [least, most] = std::minmax({pixel[0], pixel[1], pixel[2]});
      ++darkest[least], ++brightest[most];
    }
  std::size_t low = 0, high = 255;
  for (int below = darkest[0]; below < dark_pixels && low < 255;) below += darkest[++low];
  for (double above = brightest[255]; above < bright * total && high > 0;) above += brightest[--high];
  if (high >= low + few) return {};
  return {static_cast<double>(low),
          std::min(all / std::max(1.0, static_cast<double>(high) - static_cast<double>(low)), most_gain)};
}

cv::Mat stretched(const cv::Mat& bgr, const Levels& levels) {
  cv::Mat out;
  bgr.convertTo(out, -1, levels.gain, -levels.gain * levels.black);
  return out;
}

}  // namespace arkmesh::tracker
