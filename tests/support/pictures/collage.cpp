// See collage.hpp.
#include "tests/support/pictures/collage.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>

#include "tests/support/pictures/other_arenas.hpp"
#include "tests/support/pictures/photo_effects.hpp"

namespace arkmesh::tests {

Scene collage(const std::vector<Scene>& cut_from, const Collage& options) {
  std::mt19937 random(options.seed);
  const auto unit = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
  Scene out{"collage on " + options.arena, cv::Mat(options.height_px, options.width_px, CV_8UC3), {}};
  for (int y = 0; y < out.bgr.rows; ++y)
    for (int x = 0; x < out.bgr.cols; ++x) {
      const cv::Vec3d colour = arena_colour(options.arena, x, y, options.diameter_px, unit());
      for (int c = 0; c < 3; ++c) out.bgr.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(colour[c]);
    }
  const double r_px = options.diameter_px / 2;
  if (options.arena == "speckle")
    for (int i = 0; i < options.width_px * options.height_px / 300; ++i)
      cv::circle(out.bgr, cv::Point2d(unit() * options.width_px, unit() * options.height_px),
                 1 + static_cast<int>(unit() * r_px * 0.4), cv::Scalar::all(90 + 120 * unit()), cv::FILLED,
                 cv::LINE_AA);
  if (options.distractors) {
    const auto anywhere = [&] {
      return cv::Point(static_cast<int>(unit() * options.width_px), static_cast<int>(unit() * options.height_px));
    };
    cv::rectangle(out.bgr, cv::Rect(anywhere(), cv::Size(static_cast<int>(7 * r_px), static_cast<int>(10 * r_px))),
                  cv::Scalar(235, 235, 230), cv::FILLED);
    for (int i = 0; i < 4; ++i) {
      std::vector<cv::Point> cable{anywhere()};
      double angle = unit() * 6.3;
      for (int k = 0; k < 120; ++k) {
        angle += (unit() - 0.5) * 0.6;
        cable.push_back(cable.back() + cv::Point(static_cast<int>(std::lround(r_px * 0.5 * std::cos(angle))),
                                                 static_cast<int>(std::lround(r_px * 0.5 * std::sin(angle)))));
      }
      cv::polylines(out.bgr, cable, false, cv::Scalar::all(25), std::max(1, static_cast<int>(r_px * (0.2 + 0.25 * i))),
                    cv::LINE_AA);
    }
    for (int i = 0; i < 6; ++i)
      cv::circle(out.bgr, anywhere(), static_cast<int>(r_px * (0.55 + 0.05 * i)),
                 cv::Scalar(70 + 10 * i, 110 + 5 * i, 130), cv::FILLED, cv::LINE_AA);
    for (int i = 0; i < 20; ++i)
      cv::circle(out.bgr, anywhere(), std::max(1, static_cast<int>(r_px * 0.15)), cv::Scalar::all(255), cv::FILLED,
                 cv::LINE_AA);
    cv::circle(out.bgr, anywhere(), static_cast<int>(2.2 * r_px), cv::Scalar(45, 60, 30), cv::FILLED, cv::LINE_AA);
  }

  // Places: anywhere, or beside a robot already there, never overlapping.
  for (int tries = 0; static_cast<int>(out.robots.size()) < options.robots && tries < 300000; ++tries) {
    const Scene& from = cut_from[random() % cut_from.size()];
    const TrueRobot& robot = from.robots[random() % from.robots.size()];
    cv::Point2d at(r_px * 1.2 + unit() * (options.width_px - 2.4 * r_px),
                   r_px * 1.2 + unit() * (options.height_px - 2.4 * r_px));
    if (options.touching && !out.robots.empty() && unit() < 0.8) {
      const TrueRobot& beside = out.robots[random() % out.robots.size()];
      const double angle = unit() * 2 * std::numbers::pi;
      at = {beside.x_px + 2.02 * r_px * std::cos(angle), beside.y_px + 2.02 * r_px * std::sin(angle)};
    }
    if (at.x < 1.2 * r_px || at.y < 1.2 * r_px || at.x > options.width_px - 1.2 * r_px ||
        at.y > options.height_px - 1.2 * r_px)
      continue;
    if (std::any_of(out.robots.begin(), out.robots.end(), [&](const TrueRobot& other) {
          return std::hypot(other.x_px - at.x, other.y_px - at.y) < 2.01 * r_px;
        }))
      continue;
    // one neighbour in the source would be cut along with it
    if (std::any_of(from.robots.begin(), from.robots.end(), [&](const TrueRobot& other) {
          const double far = std::hypot(other.x_px - robot.x_px, other.y_px - robot.y_px);
          return far > 0 && far < 2.15 * robot.r_px;
        }))
      continue;
    const double scale = r_px / robot.r_px, turn = unit() * 2 * std::numbers::pi, c = scale * std::cos(turn),
                 d = scale * std::sin(turn);
    const cv::Matx23d move(c, -d, at.x - c * robot.x_px + d * robot.y_px, d, c, at.y - d * robot.x_px - c * robot.y_px);
    const int left = static_cast<int>(at.x - 1.3 * r_px), top = static_cast<int>(at.y - 1.3 * r_px),
              side = static_cast<int>(2.6 * r_px) + 1;
    cv::Matx23d local = move;
    local(0, 2) -= left, local(1, 2) -= top;
    // Only round the robot; what shrinks is averaged first.
    const int half = static_cast<int>(1.5 * robot.r_px) + 4;
    const cv::Rect part =
        cv::Rect(static_cast<int>(robot.x_px) - half, static_cast<int>(robot.y_px) - half, 2 * half, 2 * half) &
        cv::Rect({}, from.bgr.size());
    for (int i = 0; i < 2; ++i) local(i, 2) += local(i, 0) * part.x + local(i, 1) * part.y;
    cv::Mat patch, soft = from.bgr(part).clone();
    if (scale < 0.8) cv::GaussianBlur(soft, soft, {}, 0.4 / scale);
    cv::warpAffine(soft, patch, local, cv::Size(side, side), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    const cv::Rect all(0, 0, out.bgr.cols, out.bgr.rows);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        if (!all.contains(cv::Point(left + x, top + y))) continue;
        const double far = std::hypot(left + x - at.x, top + y - at.y),
                     cover = std::clamp(r_px * 1.01 - far + 0.5, 0.0, 1.0);
        // a soft shadow beside the robot
        const double shade =
            1 - 0.25 * std::clamp(1.25 - std::hypot(left + x - at.x - 0.12 * r_px, top + y - at.y - 0.12 * r_px) / r_px,
                                  0.0, 1.0);
        cv::Vec3b& pixel = out.bgr.at<cv::Vec3b>(top + y, left + x);
        for (int k = 0; k < 3; ++k)
          pixel[k] =
              cv::saturate_cast<std::uint8_t>(cover * patch.at<cv::Vec3b>(y, x)[k] + (1 - cover) * shade * pixel[k]);
      }
    const double led_x = move(0, 0) * robot.led_x_px + move(0, 1) * robot.led_y_px + move(0, 2);
    const double led_y = move(1, 0) * robot.led_x_px + move(1, 1) * robot.led_y_px + move(1, 2);
    out.robots.push_back({at.x, at.y, r_px, robot.led, led_x, led_y});
  }
  cv::GaussianBlur(out.bgr, out.bgr, {}, 0.6);
  add_noise(out.bgr, options.noise, options.seed + 7);
  return out;
}

}  // namespace arkmesh::tests
