// See tint.hpp.
#include "tracker/detect/white_balance.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "tracker/detect/median.hpp"

namespace arkmesh::tracker {
namespace {

constexpr std::size_t max_robots = 60;
constexpr double usual =
    0.12;  // grey things of good pictures differ by so much: natural logarithm of a ratio of channels

// How much more blue and red than green things are, in logarithms.
struct Ratios {
  std::vector<double> blue, red;
  // On a circle of this radius round the robot's centre.
  void look(const cv::Mat& bgr, const Circle& board, double far) {
    for (int i = 0; i < 16; ++i) {
      const double angle = 6.283185307179586 * i / 16;
      const double x = board.x_px + far * board.r_px * std::cos(angle),
                   y = board.y_px + far * board.r_px * std::sin(angle);
      if (!(x >= 0 && y >= 0 && x < bgr.cols && y < bgr.rows)) continue;
      const std::uint8_t* pixel = bgr.ptr<std::uint8_t>(static_cast<int>(y)) + 3 * static_cast<int>(x);
      // cut off, or nearly black: shows no tint
      if (std::max({pixel[0], pixel[1], pixel[2]}) > 250 || std::min({pixel[0], pixel[1], pixel[2]}) < 5) continue;
      blue.push_back(std::log(pixel[0] / static_cast<double>(pixel[1])));
      red.push_back(std::log(pixel[2] / static_cast<double>(pixel[1])));
    }
  }
};

// What two have in common, less what is usual.
double shared(double one, double other) {
  if (one * other <= 0) return 0;
  const double least = std::min(std::abs(one), std::abs(other));
  return std::copysign(std::max(0.0, least - usual), one);
}

}  // namespace

Light white_balance(const cv::Mat& bgr, std::span<const Circle> boards) {
  Ratios coins, table;
  const std::size_t every = boards.size() / max_robots + 1;
  for (std::size_t i = 0; i < boards.size(); i += every) {
    coins.look(bgr, boards[i], 0.35);
    table.look(bgr, boards[i], 1.25);
  }
  if (coins.blue.size() < 8 || table.blue.size() < 8) return {1, 1, 1};
  const double blue = shared(median(coins.blue), median(table.blue)),
               red = shared(median(coins.red), median(table.red));
  // Mistrust of what would be extraordinary: no camera is that wrong.
  const auto factor = [](double tint) { return std::exp(-std::clamp(tint, -0.7, 0.7)); };
  return {factor(blue), 1, factor(red)};
}

}  // namespace arkmesh::tracker
