// See other_arenas.hpp.
#include "tests/support/pictures/other_arenas.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace arkmesh::tests {
namespace {

cv::Vec3d median_colour(const cv::Mat& bgr) {
  cv::Vec3d colour;
  for (int c = 0; c < 3; ++c) {
    std::vector<std::uint8_t> values;
    for (int y = 0; y < bgr.rows; y += 7)
      for (int x = 0; x < bgr.cols; x += 7) values.push_back(bgr.at<cv::Vec3b>(y, x)[c]);
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    colour[c] = values[values.size() / 2];
  }
  return colour;
}

// A number 0..1 of a place, the same in every run.
double scattered(int x, int y) {
  std::uint32_t mixed = static_cast<std::uint32_t>(x) * 374761393U + static_cast<std::uint32_t>(y) * 668265263U;
  mixed = (mixed ^ (mixed >> 13)) * 1274126177U;
  return static_cast<double>((mixed ^ (mixed >> 16)) & 0xFFFFU) / 65535.0;
}

}  // namespace

Scene emptied(const Scene& scene) {
  Scene out{scene.name + " emptied", scene.bgr.clone(), {}};
  cv::Mat known(scene.bgr.size(), CV_8U, cv::Scalar(255));
  for (const TrueRobot& robot : scene.robots)
    cv::circle(known, cv::Point2d(robot.x_px, robot.y_px), static_cast<int>(1.5 * robot.r_px), cv::Scalar(0),
               cv::FILLED);
  // What is missing is the mean of what is known near it, ever farther away.
  cv::Mat picture, weight, filled = known.clone();
  scene.bgr.convertTo(picture, CV_32FC3);
  for (double sigma = 4; cv::countNonZero(filled) < static_cast<int>(filled.total()) && sigma < 500; sigma *= 1.6) {
    known.convertTo(weight, CV_32F, 1 / 255.0);
    cv::Mat weights, sums, weight3;
    cv::merge(std::vector<cv::Mat>{weight, weight, weight}, weight3);
    cv::GaussianBlur(picture.mul(weight3), sums, {}, sigma);
    cv::GaussianBlur(weight, weights, {}, sigma);
    for (int y = 0; y < filled.rows; ++y)
      for (int x = 0; x < filled.cols; ++x) {
        if (filled.at<std::uint8_t>(y, x) || weights.at<float>(y, x) < 0.02F) continue;
        for (int c = 0; c < 3; ++c)
          out.bgr.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(
              static_cast<double>(sums.at<cv::Vec3f>(y, x)[c] / weights.at<float>(y, x)) +
              3 * (scattered(x, y + 1000 * c) - 0.5));
        filled.at<std::uint8_t>(y, x) = 255;
      }
  }
  return out;
}

cv::Vec3d arena_colour(const std::string& arena, double x, double y, double robot_px, double random) {
  const double across = x / robot_px, along = y / robot_px;
  if (arena == "dark") return {62, 60, 58};
  if (arena == "grey") return cv::Vec3d(52, 50, 48) * (0.9 + 0.2 * random);
  if (arena == "black") return {18, 18, 20};
  if (arena == "white") return {245, 246, 244};
  if (arena == "blue") return {170, 110, 60};
  if (arena == "felt") return cv::Vec3d(60, 120, 30) * (0.9 + 0.2 * random);
  if (arena == "carpet") return cv::Vec3d(105, 110, 120) * (0.6 + 0.8 * random);
  if (arena == "wood" || arena == "parquet") {
    const double grain = std::sin(along * 9 + 2 * std::sin(across * 0.8) + std::sin(along * 2.3) * 2);
    const cv::Vec3d wood = cv::Vec3d(90, 130, 175) * (0.93 + 0.07 * grain);
    if (arena == "wood") return wood;
    const double row = std::floor(along / 1.7), shift = row * 2.3, board = std::floor((across + shift) / 7);
    const bool seam = along / 1.7 - row < 0.03 || (across + shift) / 7 - board < 0.008;
    return wood * (0.8 + 0.4 * scattered(static_cast<int>(board), static_cast<int>(row))) * (seam ? 0.5 : 1.0);
  }
  if (arena == "checks")
    return (static_cast<int>(std::floor(across / 2)) + static_cast<int>(std::floor(along / 2))) % 2
               ? cv::Vec3d(205, 205, 205)
               : cv::Vec3d(110, 110, 110);
  if (arena == "lines") {
    const double to_line =
        std::min(std::abs(across / 2.5 - std::round(across / 2.5)), std::abs(along / 2.5 - std::round(along / 2.5)));
    return to_line < 0.02 ? cv::Vec3d(40, 40, 40) : cv::Vec3d(200, 205, 205);
  }
  if (arena == "print") {
    // lines of text: dark bits in rows
    const double row = std::floor(along * 3), in_row = along * 3 - row;
    const bool ink = in_row < 0.6 &&
                     scattered(static_cast<int>(across * 9), static_cast<int>(row * 7 + std::floor(in_row * 4))) < 0.45;
    return ink ? cv::Vec3d(60, 60, 60) : cv::Vec3d(215, 215, 215);
  }
  return {168, 172, 170};
}

Scene on_arena(const Scene& scene, const std::string& arena) {
  Scene out{scene.name + " on " + arena, scene.bgr.clone(), scene.robots, scene.also};
  const cv::Vec3d usual = median_colour(scene.bgr);
  const double robot_px = scene.robots.empty() ? 40 : 2 * scene.robots[0].r_px;
  cv::Mat robots(scene.bgr.size(), CV_32F, cv::Scalar(0));
  for (const TrueRobot& robot : scene.robots) {
    const int reach = static_cast<int>(1.1 * robot.r_px) + 2;
    for (int y = std::max(0, static_cast<int>(robot.y_px) - reach);
         y < std::min(robots.rows, static_cast<int>(robot.y_px) + reach); ++y)
      for (int x = std::max(0, static_cast<int>(robot.x_px) - reach);
           x < std::min(robots.cols, static_cast<int>(robot.x_px) + reach); ++x) {
        const double cover = std::clamp(1.01 * robot.r_px - std::hypot(x - robot.x_px, y - robot.y_px) + 0.5, 0.0, 1.0);
        robots.at<float>(y, x) = std::max(robots.at<float>(y, x), static_cast<float>(cover));
      }
  }
  for (int y = 0; y < out.bgr.rows; ++y)
    for (int x = 0; x < out.bgr.cols; ++x) {
      const double cover = static_cast<double>(robots.at<float>(y, x));
      const cv::Vec3d colour = arena_colour(arena, x, y, robot_px, scattered(x, y));
      cv::Vec3b& pixel = out.bgr.at<cv::Vec3b>(y, x);
      for (int c = 0; c < 3; ++c)
        pixel[c] = cv::saturate_cast<std::uint8_t>(cover * pixel[c] +
                                                   (1 - cover) * colour[c] * std::min(1.3, pixel[c] / usual[c]));
    }
  cv::GaussianBlur(out.bgr, out.bgr, {}, 0.5);
  return out;
}

}  // namespace arkmesh::tests
