// Robots that carry markers, as a camera sees them.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "emulator/camera.hpp"

namespace arkmesh::emulator {

// A drum: what is seen of its side, and its top, through which the LED shines.
void Camera::add_marked_body(const sim_ode::SimulatedArena::Seen& robot, cv::Mat& out) const {
  constexpr int corners = 32, fraction_bits = 4;
  std::vector<cv::Point> top, all;
  const auto add = [&](double angle, double z_m, std::vector<cv::Point>& to) {
    const auto at = model_.project(robot.pose.x_m + scene_.body_radius_m * std::cos(angle),
                                   robot.pose.y_m + scene_.body_radius_m * std::sin(angle), z_m);
    if (!at || std::abs(at->x) > 1e4 || std::abs(at->y) > 1e4) return false;
    to.emplace_back(static_cast<int>(std::lround(at->x * (1 << fraction_bits))),
                    static_cast<int>(std::lround(at->y * (1 << fraction_bits))));
    return true;
  };
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    if (!add(angle, scene_.robot_height_m, top) || !add(angle, 0, all)) return;
  }
  const auto middle = model_.project_near(robot.pose.x_m, robot.pose.y_m, scene_.robot_height_m);
  if (!middle) return;
  const double light = gain(robot, *middle);
  all.insert(all.end(), top.begin(), top.end());
  std::vector<cv::Point> outline;
  cv::convexHull(all, outline);
  cv::fillConvexPoly(out, outline, cv::Scalar(150, 152, 152) * light, cv::LINE_AA, fraction_bits);
  constexpr double dark = 0.35;
  const bool on = robot.red + robot.green + robot.blue > 0;
  const auto part = [&](float led) {
    return (on ? 215 * (dark + (1 - dark) * static_cast<double>(led)) : 195.0) * light;
  };
  cv::fillConvexPoly(out, top, {part(robot.blue), part(robot.green), part(robot.red)}, cv::LINE_AA, fraction_bits);
}

// Where its corners are projected to, drawn several times finer and averaged over the exposure.
void Camera::add_marker(const sim_ode::SimulatedArena::Seen& robot, const cv::Mat& marker, cv::Mat& out) const {
  constexpr int finer = 4;
  const double half_m = scene_.marker_m / 2 * (marker_squares_ + 2) / marker_squares_;
  const auto corners_at = [&](double share) -> std::optional<std::array<cv::Point2f, 4>> {
    const double heading = robot.pose.heading_rad + share * robot.moved.heading_rad, c = std::cos(heading),
                 s = std::sin(heading);
    std::array<cv::Point2f, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) {  // clockwise as printed, from the upper left; its top is ahead
      const double ahead = i < 2 ? half_m : -half_m, left = i == 0 || i == 3 ? half_m : -half_m;
      const auto at =
          model_.project(robot.pose.x_m + share * robot.moved.x_m + ahead * c - left * s,
                         robot.pose.y_m + share * robot.moved.y_m + ahead * s + left * c, scene_.robot_height_m);
      if (!at) return {};
      corners[i] = *at;
    }
    return corners;
  };
  const auto first = corners_at(-0.5), last = corners_at(0.5);
  if (!first || !last) return;
  std::vector<cv::Point2f> all(first->begin(), first->end());
  all.insert(all.end(), last->begin(), last->end());
  constexpr int margin_px = 4;
  const cv::Rect around = cv::boundingRect(all);
  if (std::abs(around.x) > 10'000 || std::abs(around.y) > 10'000 || around.width > 2000 || around.height > 2000) return;
  const cv::Rect box = around + cv::Size(2 * margin_px, 2 * margin_px) - cv::Point(margin_px, margin_px);
  double way_px = 0;
  for (std::size_t i = 0; i < 4; ++i) way_px = std::max(way_px, cv::norm((*last)[i] - (*first)[i]));
  const int times = std::clamp(static_cast<int>(2 * way_px) + 1, 1, 24);

  const auto size = static_cast<float>(marker.cols);
  const std::array<cv::Point2f, 4> from{cv::Point2f{0, 0}, {size, 0}, {size, size}, {0, size}};
  // paper and print: how much of the light they give back, and how much of what lies below they hide
  cv::Mat paper, ink, cover;
  marker.convertTo(ink, CV_32F, 210.0 / 255, 25);
  const cv::Mat whole(marker.size(), CV_32F, cv::Scalar(1));
  for (int k = 0; k < times; ++k) {
    auto to = *corners_at((k + 0.5) / times - 0.5);
    for (cv::Point2f& corner : to)  // of pixels, whose middles are whole numbers
      corner = (corner - cv::Point2f(box.tl()) + cv::Point2f(0.5F, 0.5F)) * finer - cv::Point2f(0.5F, 0.5F);
    auto texture = from;
    for (cv::Point2f& corner : texture) corner -= cv::Point2f(0.5F, 0.5F);
    const cv::Mat map = cv::getPerspectiveTransform(texture.data(), to.data());
    cv::Mat drawn, hides;
    cv::warpPerspective(ink, drawn, map, box.size() * finer);
    cv::warpPerspective(whole, hides, map, box.size() * finer);
    cv::resize(drawn, drawn, box.size(), 0, 0, cv::INTER_AREA);
    cv::resize(hides, hides, box.size(), 0, 0, cv::INTER_AREA);
    paper = k == 0 ? drawn : paper + drawn;
    cover = k == 0 ? hides : cover + hides;
  }
  if (settings_.blur_px > 0) {
    cv::GaussianBlur(paper, paper, {}, settings_.blur_px);
    cv::GaussianBlur(cover, cover, {}, settings_.blur_px);
  }
  const auto middle = model_.project_near(robot.pose.x_m, robot.pose.y_m, scene_.robot_height_m);
  if (!middle) return;
  const auto light = static_cast<float>(gain(robot, *middle));
  const cv::Rect seen = box & cv::Rect(0, 0, out.cols, out.rows);
  for (int y = seen.y; y < seen.br().y; ++y)
    for (int x = seen.x; x < seen.br().x; ++x) {
      const float under = 1 - cover.at<float>(y - box.y, x - box.x) / static_cast<float>(times),
                  over = light * paper.at<float>(y - box.y, x - box.x) / static_cast<float>(times);
      std::uint8_t* const pixel = out.ptr<std::uint8_t>(y) + 3 * x;
      for (int c = 0; c < 3; ++c)
        pixel[c] = cv::saturate_cast<std::uint8_t>(static_cast<float>(pixel[c]) * under + over);
    }
}

}  // namespace arkmesh::emulator
