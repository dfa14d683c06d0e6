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

// What the net is shown, as training/look.py (ANGLES, RADII, AGAIN, SHOWN, MARGIN, LARGEST) has it:
constexpr int angles = 64, radii = 24;  // of the crop: a row for each direction
constexpr int again = 25;               // of the first rows, repeated after the last: a circle has no end
constexpr double shown = 1.5;           // radii from the centre outwards
constexpr double margin = 1.1;          // so much more is copied: halving an odd length loses a pixel
constexpr double largest_px = 16;       // the picture of a circle with a larger radius is halved
constexpr std::size_t at_once = 16;     // pictures; larger batches spend more time on fresh memory

// Beyond these logits the mirrored picture is not looked at. It would have had -0.5 at most, or 5.8 at least, over
// 10,572 circles of six pictures of electronics and of the labelled ones.
constexpr float clearly_none = -5, clearly_robot = 7;

// The surroundings of the circle in polar coordinates, with brightness and contrast normalised as shown() in
// training/look.py does.
cv::Mat surroundings(const cv::Mat& bgr, const Circle& circle) {
  const int far = static_cast<int>(margin * shown * circle.r_px) + 3;
  const int left = static_cast<int>(std::lround(circle.x_px)) - far,
            top = static_cast<int>(std::lround(circle.y_px)) - far;
  const cv::Rect wanted(left, top, 2 * far + 1, 2 * far + 1), there = wanted & cv::Rect({}, bgr.size());
  if (there.empty()) return cv::Mat::zeros(angles + again, radii, CV_32FC3);
  cv::Mat part;
  cv::copyMakeBorder(bgr(there), part, there.y - top, wanted.br().y - there.br().y, there.x - left,
                     wanted.br().x - there.br().x, cv::BORDER_REPLICATE);
  double x = circle.x_px - left, y = circle.y_px - top, r = circle.r_px;
  for (; r > largest_px; x = (x - 0.5) / 2, y = (y - 0.5) / 2, r /= 2) {
    const cv::Size half(part.cols / 2, part.rows / 2);
    cv::Mat smaller;
    cv::resize(part(cv::Rect(0, 0, 2 * half.width, 2 * half.height)), smaller, half, 0, 0, cv::INTER_AREA);
    part = smaller;
  }
  cv::Mat crop, values, round;
  const cv::Point2f centre(static_cast<float>(x), static_cast<float>(y));
  cv::warpPolar(part, crop, {radii, angles}, centre, shown * r, cv::INTER_LINEAR | cv::WARP_FILL_OUTLIERS);
  cv::Scalar mean, spread;
  cv::meanStdDev(crop.reshape(1), mean, spread);
  crop.convertTo(values, CV_32F, 1 / (spread[0] + 8), -mean[0] / (spread[0] + 8));
  cv::copyMakeBorder(values, round, 0, again, 0, 0, cv::BORDER_WRAP);
  return round;
}

cv::Mat mirrored(const cv::Mat& round) {
  cv::Mat other_way, out;
  cv::flip(round.rowRange(0, angles), other_way, 0);
  cv::copyMakeBorder(other_way, out, 0, again, 0, 0, cv::BORDER_WRAP);
  return out;
}

}  // namespace

struct LookNet::Net {
  cv::dnn::Net net =
      cv::dnn::readNetFromONNX(arkmesh_look_net, static_cast<std::size_t>(arkmesh_look_net_end - arkmesh_look_net));

  std::vector<float> logits(const std::vector<cv::Mat>& pictures) {
    net.setInput(cv::dnn::blobFromImages(pictures));
    const cv::Mat all = net.forward();
    return {all.ptr<float>(), all.ptr<float>() + all.total()};
  }
};

LookNet::LookNet() : net_(std::make_unique<Net>()) {}
LookNet::~LookNet() = default;
LookNet::LookNet(LookNet&&) noexcept = default;
LookNet& LookNet::operator=(LookNet&&) noexcept = default;

std::vector<double> LookNet::probabilities(const cv::Mat& bgr, const std::vector<Circle>& circles) {
  std::vector<float> logits;
  std::vector<cv::Mat> some, mirrors;
  std::vector<std::size_t> unclear;
  const auto look_in_mirror = [&] {
    const std::vector<float> seen = net_->logits(mirrors);
    for (std::size_t i = 0; i < seen.size(); ++i) logits[unclear[i]] = (logits[unclear[i]] + seen[i]) / 2;
    unclear.clear();
    mirrors.clear();
  };
  for (const Circle& circle : circles) {
    some.push_back(surroundings(bgr, circle));
    if (some.size() < at_once && logits.size() + some.size() < circles.size()) continue;
    const std::vector<float> seen = net_->logits(some);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      logits.push_back(seen[i]);
      if (seen[i] < clearly_none || seen[i] > clearly_robot) continue;
      unclear.push_back(logits.size() - 1);
      mirrors.push_back(mirrored(some[i]));
      if (mirrors.size() == at_once) look_in_mirror();
    }
    some.clear();
  }
  if (!mirrors.empty()) look_in_mirror();
  std::vector<double> all;
  for (const float logit : logits) all.push_back(1 / (1 + std::exp(-static_cast<double>(logit))));
  return all;
}

}  // namespace arkmesh::tracker
