// See white_balance.hpp.
#include "tracker/detect/white_balance.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "tracker/detect/median.hpp"

namespace arkmesh::tracker {
namespace {

constexpr std::size_t max_robots = 60;
// A cast of good pictures, natural logarithm of a ratio of channels; and by how much more it is surely false. Chosen on
// the real pictures with casts and other gammas.
constexpr double usual = 0.05, surely_more = 0.05;

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
      if (std::max({pixel[0], pixel[1], pixel[2]}) > most_certain || std::min({pixel[0], pixel[1], pixel[2]}) < 5)
        continue;
      blue.push_back(std::log(pixel[0] / static_cast<double>(pixel[1])));
      red.push_back(std::log(pixel[2] / static_cast<double>(pixel[1])));
    }
  }
};

// What two have in common.
double shared(double one, double other) {
  return one * other <= 0 ? 0 : std::copysign(std::min(std::abs(one), std::abs(other)), one);
}

}  // namespace

Light white_balance(const cv::Mat& bgr, std::span<const Circle> boards) {
  Ratios coins, arena;
  const std::size_t every = boards.size() / max_robots + 1;
  for (std::size_t i = 0; i < boards.size(); i += every) {
    coins.look(bgr, boards[i], 0.35);
    arena.look(bgr, boards[i], 1.25);
  }
  if (coins.blue.size() < 8 || arena.blue.size() < 8) return {1, 1, 1};
  const double coin_blue = median(coins.blue), coin_red = median(coins.red), arena_blue = median(arena.blue),
               arena_red = median(arena.red);
  const double blue = shared(coin_blue, arena_blue), red = shared(coin_red, arena_red);
  // A cast is all of a picture's: it is more than what the two differ by.
  const double more = std::hypot(blue, red) - std::hypot(coin_blue - arena_blue, coin_red - arena_red) - usual;
  const double trust = std::clamp(more / surely_more, 0.0, 1.0);
  // Mistrust of what would be extraordinary: no camera is that wrong.
  const auto factor = [&](double tint) { return std::exp(-trust * std::clamp(tint, -0.7, 0.7)); };
  return {factor(blue), 1, factor(red)};
}

bool monochrome(const cv::Mat& bgr, std::span<const Circle> boards) {
  constexpr int max_difference = 3, rows = 12;
  for (const Circle& board : boards)
    for (int i = 0; i < rows * rows; ++i) {
      const double x = board.x_px + board.r_px * (2.0 * (i % rows) / (rows - 1) - 1),
                   y = board.y_px + board.r_px * (2.0 * (i / rows) / (rows - 1) - 1);
      if (!(x >= 0 && y >= 0 && x < bgr.cols && y < bgr.rows)) continue;
      const std::uint8_t* const pixel = bgr.ptr<std::uint8_t>(static_cast<int>(y)) + 3 * static_cast<int>(x);
      const auto [least, most] = std::minmax({pixel[0], pixel[1], pixel[2]});
      if (most - least > max_difference) return false;
    }
  return !boards.empty();
}

}  // namespace arkmesh::tracker
