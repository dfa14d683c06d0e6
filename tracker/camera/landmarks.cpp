#include "tracker/camera/landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "tracker/detect/downsampled_image.hpp"

namespace arkmesh::tracker {
namespace {

constexpr int landmark_half = Landmark::side / 2;
constexpr int field_columns = 12, field_rows = 9;  // the picture is divided into so many fields, each with its best one
constexpr std::size_t max_landmarks = 40;          // the best of them
constexpr double certain_px = 0.12;                // a landmark's place is known to so much, given the picture's noise

Landmark cut_out(const cv::Mat& bgr, const cv::Mat& small, int by, const cv::Point& at) {
  Landmark out{.x_px = at.x, .y_px = at.y, .grey = {}, .rough = {}};
  for (int y = -landmark_half; y <= landmark_half; ++y)
    for (int x = -landmark_half; x <= landmark_half; ++x)
      out.grey.push_back(cv::saturate_cast<std::uint8_t>(grey_of(bgr.at<cv::Vec3b>(at.y + y, at.x + x))));
  const cv::Mat rough = small(rough_patch(at.x, at.y, by, small.size()));
  out.rough.assign(rough.begin<std::uint8_t>(), rough.end<std::uint8_t>());
  return out;
}

// Standard deviation of its place in a direction in which it is known worst; nothing when the noise has slopes like it.
std::optional<double> sigma_px(const Template& landmark, double noise) {
  // noise has slopes of its own, in smoothed levels 15/256 of its variance a pixel
  const double own = 15.0 / 256 * noise * noise * Template::side * Template::side;
  const double least = (landmark.xx + landmark.yy) / 2 - std::hypot((landmark.xx - landmark.yy) / 2, landmark.xy) - own;
  if (!(least > 0)) return {};
  return noise / std::sqrt(least);
}

}  // namespace

int rough_block(int width_px) {
  return std::max(1, (width_px + 479) / 480);
}

cv::Mat downsampled_grey(const cv::Mat& bgr, int by) {
  cv::Mat small, grey;
  cv::resize(bgr, small, {}, 1.0 / by, 1.0 / by, cv::INTER_AREA);
  cv::cvtColor(small, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

cv::Rect rough_patch(int x_px, int y_px, int by, const cv::Size& of) {
  constexpr int side = Landmark::rough_side;
  return {std::clamp(x_px / by - side / 2, 0, of.width - side), std::clamp(y_px / by - side / 2, 0, of.height - side),
          side, side};
}

Template template_of(const Landmark& landmark) {
  constexpr std::size_t wide = Landmark::side, smooth_wide = wide - 2, side = Template::side;
  const std::vector<std::uint8_t>& patch = landmark.grey;
  std::vector<float> smooth;
  for (std::size_t y = 1; y <= smooth_wide; ++y)
    for (std::size_t x = 1; x <= smooth_wide; ++x) {
      const auto across = [&patch](std::size_t k) { return patch[k - 1] + 2 * patch[k] + patch[k + 1]; };
      const std::size_t k = y * wide + x;
      smooth.push_back(static_cast<float>(across(k - wide) + 2 * across(k) + across(k + wide)) / 16);
    }
  Template out;
  for (std::size_t y = 1; y <= side; ++y)
    for (std::size_t x = 1; x <= side; ++x) {
      const std::size_t k = y * smooth_wide + x;
      out.grey.push_back(smooth[k]);
      out.along_x.push_back(0.5F * (smooth[k + 1] - smooth[k - 1]));
      out.along_y.push_back(0.5F * (smooth[k + smooth_wide] - smooth[k - smooth_wide]));
    }
  // what is compared with it has no mean, so its slopes have none
  const auto without_mean = [](std::vector<float>& values) {
    float mean = 0;
    for (const float value : values) mean += value / static_cast<float>(values.size());
    for (float& value : values) value -= mean;
  };
  for (std::vector<float>* const values : {&out.grey, &out.along_x, &out.along_y}) without_mean(*values);
  for (std::size_t k = 0; k < out.grey.size(); ++k) {
    out.energy += out.grey[k] * out.grey[k];
    out.xx += out.along_x[k] * out.along_x[k];
    out.xy += out.along_x[k] * out.along_y[k];
    out.yy += out.along_y[k] * out.along_y[k];
  }
  return out;
}

std::vector<Landmark> find_landmarks(const cv::Mat& bgr, std::span<const Detection> robots,
                                     const Calibration& calibration) {
  const int rough_by = rough_block(bgr.cols);
  const cv::Mat rough = downsampled_grey(bgr, rough_by);
  if (rough.cols <= Landmark::rough_side || rough.rows <= Landmark::rough_side) return {};
  const int by = (bgr.cols + 959) / 960;  // corners are chosen in a smaller picture
  cv::Mat strength;
  cv::cornerMinEigenVal(downsampled_grey(bgr, by), strength, std::max(3, Template::side / by), 3);
  const double noise = std::max(1.0, noise_of(bgr));
  std::vector<std::pair<double, Landmark>> found;
  for (int field = 0; field < field_columns * field_rows; ++field) {
    const int column = field % field_columns, row = field / field_columns;
    const int left = column * strength.cols / field_columns, right = (column + 1) * strength.cols / field_columns;
    const int top = row * strength.rows / field_rows, bottom = (row + 1) * strength.rows / field_rows;
    float best = 0;
    cv::Point at(-1, -1);
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) {
        if (strength.at<float>(y, x) <= best) continue;
        const cv::Point here(x * by + by / 2, y * by + by / 2);
        // a robot and its light
        const auto hidden = [&](const Detection& robot) {
          return std::hypot(robot.x_px - here.x, robot.y_px - here.y) < 2 * robot.r_px + 1.5 * landmark_half;
        };
        if (std::any_of(robots.begin(), robots.end(), hidden)) continue;
        best = strength.at<float>(y, x);
        at = here;
      }
    if (at.x < landmark_half || at.y < landmark_half || at.x + landmark_half >= bgr.cols ||
        at.y + landmark_half >= bgr.rows ||
        !calibration.to_arena({static_cast<double>(at.x), static_cast<double>(at.y)}, 0))
      continue;
    Landmark landmark = cut_out(bgr, rough, rough_by, at);
    const auto sigma = sigma_px(template_of(landmark), noise);
    if (sigma && *sigma < certain_px) found.emplace_back(*sigma, std::move(landmark));
  }
  std::ranges::stable_sort(found, {}, &std::pair<double, Landmark>::first);
  if (found.size() > max_landmarks) found.resize(max_landmarks);
  std::vector<Landmark> out;
  for (auto& each : found) out.push_back(std::move(each.second));
  return out;
}

}  // namespace arkmesh::tracker
