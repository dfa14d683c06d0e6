// See look_net.hpp.
#include "tracker/detect/look_net.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

// The weights are part of the program: tracker/CMakeLists.txt puts them in.
extern "C" const char arkmesh_look_net[], arkmesh_look_net_end[];

namespace arkmesh::tracker {
namespace {

// What the net is shown, as training/look.py (SIDE, SHOWN) has it:
constexpr int side_px = 32;          // of the crop
constexpr double shown = 1.5;        // radii on each side of the centre
constexpr std::size_t at_once = 64;  // crops

// The crop round a circle, with brightness and contrast normalised as shown() in training/look.py does.
cv::Mat surroundings(const cv::Mat& bgr, const Circle& circle) {
  const int far = static_cast<int>(shown * circle.r_px) + 3;
  const int left = static_cast<int>(std::lround(circle.x_px)) - far,
            top = static_cast<int>(std::lround(circle.y_px)) - far;
  const cv::Rect wanted(left, top, 2 * far + 1, 2 * far + 1), there = wanted & cv::Rect({}, bgr.size());
  if (there.empty()) return cv::Mat::zeros(side_px, side_px, CV_32FC3);
  cv::Mat part;
  cv::copyMakeBorder(bgr(there), part, there.y - top, wanted.br().y - there.br().y, there.x - left,
                     wanted.br().x - there.br().x, cv::BORDER_REPLICATE);
  double x = circle.x_px - left, y = circle.y_px - top, r = circle.r_px;
  for (; r > side_px / 2.0; x = (x - 0.5) / 2, y = (y - 0.5) / 2, r /= 2) {
    cv::Mat half;
    cv::resize(part, half, {part.cols / 2, part.rows / 2}, 0, 0, cv::INTER_AREA);
    part = half;
  }
  const double step = 2 * shown * r / side_px, middle = (side_px - 1) / 2.0;
  const cv::Matx23d move(step, 0, x - step * middle, 0, step, y - step * middle);
  cv::Mat crop, values;
  cv::warpAffine(part, crop, move, {side_px, side_px}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  cv::Scalar mean, spread;
  cv::meanStdDev(crop.reshape(1), mean, spread);
  crop.convertTo(values, CV_32F, 1 / (spread[0] + 8), -mean[0] / (spread[0] + 8));
  return values;
}

}  // namespace

struct LookNet::Net {
  cv::dnn::Net net =
      cv::dnn::readNetFromONNX(arkmesh_look_net, static_cast<std::size_t>(arkmesh_look_net_end - arkmesh_look_net));
};

LookNet::LookNet() : net_(std::make_unique<Net>()) {}
LookNet::~LookNet() = default;
LookNet::LookNet(LookNet&&) noexcept = default;
LookNet& LookNet::operator=(LookNet&&) noexcept = default;

std::vector<double> LookNet::probabilities(const cv::Mat& bgr, const std::vector<Circle>& circles) {
  std::vector<double> all;
  std::vector<cv::Mat> some;
  for (const Circle& circle : circles) {
    some.push_back(surroundings(bgr, circle));
    if (some.size() < at_once && all.size() + some.size() < circles.size()) continue;
    net_->net.setInput(cv::dnn::blobFromImages(some));
    const cv::Mat logits = net_->net.forward();
    for (std::size_t i = 0; i < some.size(); ++i)
      all.push_back(1 / (1 + std::exp(-static_cast<double>(logits.ptr<float>()[i]))));
    some.clear();
  }
  return all;
}

}  // namespace arkmesh::tracker
