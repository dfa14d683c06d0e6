// See downsampled_image.hpp.
#include "tracker/detect/downsampled_image.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <opencv2/core.hpp>

#include "tracker/detect/wide.hpp"

namespace arkmesh::tracker {
namespace {

// Loops of their own so that they vectorise.
inline int brightest(const std::uint8_t* bgr) {
  const std::uint8_t more = bgr[0] > bgr[1] ? bgr[0] : bgr[1];
  return more > bgr[2] ? more : bgr[2];
}

ARKMESH_WIDE void take_row(const std::uint8_t* __restrict bgr, std::int16_t* __restrict out, int count) {
  for (int x = 0; x < count; ++x) out[x] = static_cast<std::int16_t>(8 * brightest(bgr + 3 * x));
}

ARKMESH_WIDE void first_row(const std::uint8_t* __restrict bgr, std::uint16_t* __restrict out, int count) {
  for (int x = 0; x < count; ++x) out[x] = static_cast<std::uint16_t>(brightest(bgr + 3 * x));
}

ARKMESH_WIDE void add_row(const std::uint8_t* __restrict bgr, std::uint16_t* __restrict out, int count) {
  for (int x = 0; x < count; ++x) out[x] = static_cast<std::uint16_t>(out[x] + brightest(bgr + 3 * x));
}

// Sums of neighbours; the usual block sizes are known to the compiler.
template <int Block>
void sum_columns(const std::uint16_t* __restrict in, std::int16_t* __restrict out, int count, int) {
  constexpr float scale = 8.0F / (Block * Block);
  for (int x = 0; x < count; ++x) {
    int sum = 0;
    for (int i = 0; i < Block; ++i) sum += in[x * Block + i];
    out[x] = static_cast<std::int16_t>(static_cast<float>(sum) * scale);
  }
}
void sum_any_columns(const std::uint16_t* __restrict in, std::int16_t* __restrict out, int count, int block) {
  const float scale = 8.0F / static_cast<float>(block * block);
  for (int x = 0; x < count; ++x, in += block) {
    int sum = 0;
    for (int i = 0; i < block; ++i) sum += in[i];
    out[x] = static_cast<std::int16_t>(static_cast<float>(sum) * scale);
  }
}

}  // namespace

void DownsampledImage::take(const cv::Mat& bgr, int from_x, int from_y, int to_x, int to_y, int block_px) {
  block = std::clamp(block_px, 1, 128);  // so that a column of one block fits 16 bits
  left = std::clamp(from_x, 0, bgr.cols);
  top = std::clamp(from_y, 0, bgr.rows);
  width = std::max(0, (std::min(to_x, bgr.cols) - left) / block);
  height = std::max(0, (std::min(to_y, bgr.rows) - top) / block);
  grey.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (grey.empty()) return;
  if (block == 1) {
    for (int y = 0; y < height; ++y)
      take_row(bgr.ptr<std::uint8_t>(top + y) + 3 * left,
               grey.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width), width);
    return;
  }
  const int used = width * block;
  sums_.resize(static_cast<std::size_t>(used));
  const auto sum = block == 2   ? sum_columns<2>
                   : block == 3 ? sum_columns<3>
                   : block == 4 ? sum_columns<4>
                                : sum_any_columns;
  for (int y = 0; y < height; ++y) {
    first_row(bgr.ptr<std::uint8_t>(top + y * block) + 3 * left, sums_.data(), used);
    for (int line = 1; line < block; ++line)
      add_row(bgr.ptr<std::uint8_t>(top + y * block + line) + 3 * left, sums_.data(), used);
    sum(sums_.data(), grey.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width), width, block);
  }
}

double noise_of(const cv::Mat& bgr) {
  // The bend of three neighbours is noise nearly everywhere; its median does not see the edges.
  std::array<int, 1024> count{};
  int total = 0;
  const int rows = std::min(bgr.rows, 24);
  for (int i = 0; i < rows; ++i) {
    const std::uint8_t* line = bgr.ptr<std::uint8_t>(static_cast<int>((i + 0.5) * bgr.rows / rows));
    for (int x = 1; x + 1 < bgr.cols; ++x) {
      const int here = brightest(line + 3 * x);
      if (here == 0 || here == 255) continue;  // cut off: shows no noise
      ++count[static_cast<std::size_t>(
          std::min(std::abs(brightest(line + 3 * x - 3) - 2 * here + brightest(line + 3 * x + 3)), 1023))];
      ++total;
    }
  }
  int median = 0;
  for (int sum = 0; median < 1023; ++median)
    if ((sum += count[static_cast<std::size_t>(median)]) * 2 >= total) break;
  return median / (0.6745 * 2.449);
}

}  // namespace arkmesh::tracker
