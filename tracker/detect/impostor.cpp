// See impostor.hpp.
#include "tracker/detect/impostor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

namespace arkmesh::tracker {
namespace {

constexpr std::size_t spokes_of_ring = 24;

// What one circle shows, in grey levels.
struct Ring {
  float median = 0, low = 0, high = 0;  // a half, a tenth and nine tenths lie below
};

Ring ring(const cv::Mat& bgr, const Circle& circle, double part) {
  std::array<float, spokes_of_ring> grey{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < spokes_of_ring; ++i) {
    const double angle = static_cast<double>(i) * 2 * std::numbers::pi / spokes_of_ring;
    const double x = circle.x_px + part * circle.r_px * std::cos(angle),
                 y = circle.y_px + part * circle.r_px * std::sin(angle);
    if (!(x >= 0 && y >= 0 && x < bgr.cols - 1 && y < bgr.rows - 1)) continue;
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const float right = static_cast<float>(x - left), below = static_cast<float>(y - top);
    const auto at = [&](int column, int row) {
      const std::uint8_t* const pixel = bgr.ptr<std::uint8_t>(row) + 3 * static_cast<std::ptrdiff_t>(column);
      return static_cast<float>(pixel[0] + 2 * pixel[1] + pixel[2]) / 4;
    };
    grey[count++] = (1 - below) * ((1 - right) * at(left, top) + right * at(left + 1, top)) +
                    below * ((1 - right) * at(left, top + 1) + right * at(left + 1, top + 1));
  }
  if (count == 0) return {};
  std::sort(grey.begin(), grey.begin() + static_cast<std::ptrdiff_t>(count));
  const auto share = [&](double part_of_all) {
    return grey[static_cast<std::size_t>(std::lround(part_of_all * static_cast<double>(count - 1)))];
  };
  return {share(0.5), share(0.1), share(0.9)};
}

}  // namespace

const char* why_no_robot(const cv::Mat& bgr, const CircleFit& circle_fit) {
  const auto show = [&](double part) { return ring(bgr, circle_fit.circle, part); };
  const Ring cell = show(0.35), board = show(0.75), rim = show(0.85), outside = show(1.25);
  // Pads round the holes of circuit boards: 1.2 to 3.4 of what is beside them; robots' boards at most 0.83.
  if (std::min(board.median, rim.median) > 1.1F * (std::max(cell.median, outside.median) + 10)) return "a bright ring";
  // The hole in a pad: bright all round it, and dark all round that. Robots on a bright surface that stand so near to
  // each other leave gaps, or touch.
  const std::array<Ring, 5> beyond = {show(1.45), show(1.7), show(1.85), show(2.0), show(2.3)};
  const float pad = std::min(show(1.15).low, show(1.3).low);
  if (pad > 1.1F * rim.median &&
      std::ranges::any_of(beyond, [&](const Ring& one) { return pad > 1.3F * (one.high + 5); }))
    return "a hole in a bright ring";
  return nullptr;
}

}  // namespace arkmesh::tracker
