// See search_net.hpp.
#include "tracker/detect/search_net.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

// The weights are part of the program: tracker/CMakeLists.txt puts them in.
extern "C" const char arkmesh_search_net[], arkmesh_search_net_end[];

namespace arkmesh::tracker {
namespace {

constexpr double trained_r_px = 5;
constexpr int cell_px = 4;  // of the net's picture to one of its answers
// The net processes a picture in tiles of one size: they fit a processor's cache, and the net's buffers are reused.
// An answer depends on at most seen_px pixels beyond its cell, so tiles overlap by twice that.
constexpr int part_px = 512, seen_px = 20;

// Where tiles begin that together cover `length` pixels.
std::vector<int> begins(int length) {
  std::vector<int> all{0};
  while (all.back() + part_px < length) all.push_back(std::min(all.back() + part_px - 2 * seen_px, length - part_px));
  return all;
}

}  // namespace

struct SearchNet::Net {
  cv::dnn::Net net = cv::dnn::readNetFromONNX(arkmesh_search_net,
                                              static_cast<std::size_t>(arkmesh_search_net_end - arkmesh_search_net));
  cv::Mat small, blob;
  std::array<cv::Mat, 4> maps;  // of the whole picture: a robot here (logit), x, y off in cells, ln(radius)
};

SearchNet::SearchNet() : net_(std::make_unique<Net>()) {}
SearchNet::~SearchNet() = default;
SearchNet::SearchNet(SearchNet&&) noexcept = default;
SearchNet& SearchNet::operator=(SearchNet&&) noexcept = default;

void SearchNet::look_at(const cv::Mat& bgr) {
  halves_.assign(1, bgr);
}

void SearchNet::find(double r_px, double min_score, std::vector<NetFind>& found) {
  const cv::Mat whole = halves_[0];
  const double scale = trained_r_px / r_px;
  const auto cells = [&](int length) { return static_cast<int>(std::lround(length * scale / cell_px)); };
  const cv::Size size(cell_px * cells(whole.cols), cell_px * cells(whole.rows));
  if (size.width < 3 * cell_px || size.height < 3 * cell_px) return;
  // From the smallest that is large enough.
  std::size_t half = 0;
  while (whole.cols * scale <= whole.cols / std::pow(2.0, static_cast<double>(half + 1))) ++half;
  while (halves_.size() <= half) {
    const cv::Mat& last = halves_.back();
    cv::Mat next;
    cv::resize(last, next, {std::max(1, last.cols / 2), std::max(1, last.rows / 2)}, 0, 0, cv::INTER_AREA);
    halves_.push_back(next);
  }
  cv::resize(halves_[half], net_->small, size, 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  const int rows = size.height / cell_px, columns = size.width / cell_px;
  for (cv::Mat& map : net_->maps) map.create(rows, columns, CV_32F);
  for (const int top : begins(size.height))
    for (const int left : begins(size.width)) {
      const cv::Rect part = cv::Rect(left, top, part_px, part_px) & cv::Rect({}, size);
      cv::dnn::blobFromImage(net_->small(part), net_->blob, 1.0 / 255);
      net_->net.setInput(net_->blob);
      cv::Mat answer = net_->net.forward();
      // Cells near an edge of the tile come from its neighbour.
      const int before_x = left > 0 ? seen_px / cell_px : 0, before_y = top > 0 ? seen_px / cell_px : 0;
      const cv::Rect here(before_x, before_y, answer.size[3] - before_x, answer.size[2] - before_y);
      for (std::size_t i = 0; i < net_->maps.size(); ++i) {
        const cv::Mat map(answer.size[2], answer.size[3], CV_32F, answer.ptr<float>(0, static_cast<int>(i)));
        map(here).copyTo(net_->maps[i](here + cv::Point(left / cell_px, top / cell_px)));
      }
    }
  const auto at = [&](std::size_t map, int y, int x) { return net_->maps[map].at<float>(y, x); };
  const auto least = static_cast<float>(std::log(min_score / (1 - min_score)));
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const float here = at(0, y, x);
      if (here < least) continue;
      bool peak = true;
      for (int v = std::max(0, y - 1); v <= std::min(rows - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(columns - 1, x + 1); ++u)
          peak = peak &&
                 (at(0, v, u) < here || (v == y && u == x) || (at(0, v, u) == here && (v > y || (v == y && u > x))));
      if (!peak) continue;
      const auto in_picture = [&](int cell, float off, int length, int small) {
        return (cell + 0.5 + static_cast<double>(off)) * cell_px * length / small - 0.5;
      };
      found.push_back(
          {{in_picture(x, at(1, y, x), whole.cols, size.width), in_picture(y, at(2, y, x), whole.rows, size.height),
            r_px * std::exp(std::clamp(static_cast<double>(at(3, y, x)), -0.5, 0.5))},
           1 / (1 + std::exp(-static_cast<double>(here)))});
    }
}

}  // namespace arkmesh::tracker
