#include "tracker/brush.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace arkmesh::tracker {
namespace {

constexpr double farthest_px = 1e5;  // beyond it nothing is drawn

double font_scale(double size_px) {
  return std::clamp(size_px / 40.0, 0.3, 1.2);
}

int font_thickness(double scale) {
  return std::max(1, static_cast<int>(2 * scale));
}

}  // namespace

std::optional<cv::Point> fine(const std::optional<Point>& at) {
  if (!at || !(std::abs(at->x) < farthest_px && std::abs(at->y) < farthest_px)) return {};
  return cv::Point(static_cast<int>(std::lround(at->x * (1 << fine_shift))),
                   static_cast<int>(std::lround(at->y * (1 << fine_shift))));
}

std::vector<cv::Point> ring(const Calibration& camera, Point centre, double radius_m, double height_m) {
  std::vector<cv::Point> points;
  constexpr int steps = 48;
  for (int i = 0; i < steps; ++i) {
    const double angle = 2 * std::numbers::pi * i / steps;
    const auto at =
        fine(camera.to_pixel({centre.x + radius_m * std::cos(angle), centre.y + radius_m * std::sin(angle)}, height_m));
    if (!at) return {};
    points.push_back(*at);
  }
  return points;
}

void write(cv::Mat& picture, const std::string& text, Point at, double size_px, const cv::Scalar& colour) {
  const double scale = font_scale(size_px);
  const int thick = font_thickness(scale);
  const cv::Point where(static_cast<int>(at.x), static_cast<int>(at.y));
  cv::putText(picture, text, where, cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar::all(0), thick + 2, cv::LINE_AA);
  cv::putText(picture, text, where, cv::FONT_HERSHEY_SIMPLEX, scale, colour, thick, cv::LINE_AA);
}

void write_centred(cv::Mat& picture, const std::string& text, Point at, double size_px, const cv::Scalar& colour) {
  const double scale = font_scale(size_px);
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, font_thickness(scale), nullptr);
  write(picture, text, {at.x - size.width / 2.0, at.y + size.height / 2.0}, size_px, colour);
}

}  // namespace arkmesh::tracker
