// See picture_changes.hpp.
#include "tests/support/picture_changes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

namespace arkmesh::tests {
namespace {

Scene changed(const Scene& scene, const std::function<void(cv::Mat&)>& change) {
  Scene out{scene.name, scene.bgr.clone(), scene.robots};
  change(out.bgr);
  return out;
}

// Moves all pixels and all that is known by a 3 x 3 matrix.
Scene warped(const Scene& scene, const cv::Matx33d& move, cv::Size size) {
  Scene out{scene.name, {}, {}};
  cv::warpPerspective(scene.bgr, out.bgr, move, size, cv::INTER_AREA, cv::BORDER_REPLICATE);
  const auto moved = [&](double x, double y) {
    const cv::Vec3d at = move * cv::Vec3d(x, y, 1);
    return cv::Point2d(at[0] / at[2], at[1] / at[2]);
  };
  for (const TrueRobot& robot : scene.robots) {
    const cv::Point2d at = moved(robot.x_px, robot.y_px), led = moved(robot.led_x_px, robot.led_y_px);
    const cv::Point2d right = moved(robot.x_px + robot.r_px, robot.y_px), down = moved(robot.x_px, robot.y_px + robot.r_px);
    const double r_px = (cv::norm(right - at) + cv::norm(down - at)) / 2;
    // what leaves the picture, even in part, is not asked for
    if (at.x < r_px || at.y < r_px || at.x > size.width - r_px || at.y > size.height - r_px) continue;
    out.robots.push_back({at.x, at.y, r_px, robot.led, led.x, led.y});
  }
  return out;
}

void apply_gamma(cv::Mat& bgr, double gamma) {
  cv::Mat table(1, 256, CV_8U);
  for (int i = 0; i < 256; ++i) table.at<std::uint8_t>(i) = cv::saturate_cast<std::uint8_t>(255 * std::pow(i / 255.0, gamma));
  cv::LUT(bgr, table, bgr);
}

void add_noise(cv::Mat& bgr, double deviation, unsigned seed) {
  cv::RNG random(seed);
  cv::Mat noise(bgr.size(), CV_16SC3);
  random.fill(noise, cv::RNG::NORMAL, 0, deviation);
  cv::add(bgr, noise, bgr, cv::noArray(), CV_8UC3);
}

void multiply_by(cv::Mat& bgr, const std::function<double(double, double)>& gain) {
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const double by = gain(static_cast<double>(x) / bgr.cols, static_cast<double>(y) / bgr.rows);
      for (int c = 0; c < 3; ++c) bgr.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(by * bgr.at<cv::Vec3b>(y, x)[c]);
    }
}

void compress(cv::Mat& bgr, int quality) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  bgr = cv::imdecode(bytes, cv::IMREAD_COLOR);
}

void turn_hue(cv::Mat& bgr, int half_degrees) {
  cv::Mat hsv;
  cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV);
  for (int y = 0; y < hsv.rows; ++y)
    for (int x = 0; x < hsv.cols; ++x)
      hsv.at<cv::Vec3b>(y, x)[0] = static_cast<std::uint8_t>((hsv.at<cv::Vec3b>(y, x)[0] + half_degrees + 180) % 180);
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
}

PictureChange pixels(std::string name, const std::function<void(cv::Mat&)>& change, bool keeps_colours = true) {
  return {std::move(name), [change](const Scene& scene) { return changed(scene, change); }, keeps_colours};
}

PictureChange moved(std::string name, const std::function<std::pair<cv::Matx33d, cv::Size>(cv::Size)>& move) {
  return {std::move(name), [move](const Scene& scene) {
            const auto [matrix, size] = move(scene.bgr.size());
            return warped(scene, matrix, size);
          }};
}

// Colour of the table at a pixel; textures have the size of robots' parts, where they hurt.
cv::Vec3d table_colour(const std::string& table, double x, double y, double robot_px, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  if (table == "dark") return {62, 60, 58};
  if (table == "black") return {18, 18, 20};
  if (table == "felt") return cv::Vec3d(60, 120, 30) * (0.9 + 0.2 * unit(random));
  if (table == "wood") {
    const double grain = std::sin(y / robot_px * 9 + 2 * std::sin(x / robot_px * 0.8) + std::sin(y / robot_px * 2.3) * 2);
    return cv::Vec3d(90, 130, 175) * (0.93 + 0.07 * grain);
  }
  if (table == "checks")
    return (static_cast<int>(std::floor(x / robot_px / 2)) + static_cast<int>(std::floor(y / robot_px / 2))) % 2 ? cv::Vec3d(205, 205, 205)
                                                                                                                 : cv::Vec3d(110, 110, 110);
  return {168, 172, 170};
}

}  // namespace

std::vector<PictureChange> picture_changes() {
  std::vector<PictureChange> list;
  list.push_back(pixels("as it is", [](cv::Mat&) {}));
  list.push_back(moved("turned 90 deg", [](cv::Size s) {
    return std::pair(cv::Matx33d(0, -1, s.height - 1, 1, 0, 0, 0, 0, 1), cv::Size(s.height, s.width));
  }));
  list.push_back(moved("turned 33 deg", [](cv::Size s) {
    const double c = std::cos(0.576), d = std::sin(0.576), big = std::hypot(s.width, s.height);
    return std::pair(
        cv::Matx33d(c, -d, big / 2 - c * s.width / 2 + d * s.height / 2, d, c, big / 2 - d * s.width / 2 - c * s.height / 2, 0, 0, 1),
        cv::Size(static_cast<int>(big), static_cast<int>(big)));
  }));
  list.push_back(moved("mirrored", [](cv::Size s) { return std::pair(cv::Matx33d(-1, 0, s.width - 1, 0, 1, 0, 0, 0, 1), s); }));
  list.push_back(pixels("gamma 0.6", [](cv::Mat& m) { apply_gamma(m, 0.6); }));
  list.push_back(pixels("gamma 1.6", [](cv::Mat& m) { apply_gamma(m, 1.6); }));
  list.push_back(pixels("brightness 0.3", [](cv::Mat& m) { m.convertTo(m, -1, 0.3, 0); }));
  list.push_back(pixels("brightness 0.6", [](cv::Mat& m) { m.convertTo(m, -1, 0.6, 0); }));
  list.push_back(pixels("brightness 1.4", [](cv::Mat& m) { m.convertTo(m, -1, 1.4, 0); }));
  list.push_back(pixels("light 0.4..1.3 across",
                        [](cv::Mat& m) { multiply_by(m, [](double x, double y) { return 0.4 + 0.9 * (0.7 * x + 0.3 * y); }); }));
  list.push_back(pixels("vignette", [](cv::Mat& m) {
    multiply_by(m, [](double x, double y) { return 1.15 - 1.4 * ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5)); });
  }));
  list.push_back(pixels("noise 8", [](cv::Mat& m) { add_noise(m, 8, 1); }));
  list.push_back(pixels("noise 16", [](cv::Mat& m) { add_noise(m, 16, 2); }));
  list.push_back(pixels("blur 1.5 px", [](cv::Mat& m) { cv::GaussianBlur(m, m, {}, 1.5); }));
  list.push_back(pixels("blur 3 px", [](cv::Mat& m) { cv::GaussianBlur(m, m, {}, 3); }));
  list.push_back(pixels("motion blur 7 px", [](cv::Mat& m) { cv::blur(m, m, {7, 1}); }));
  list.push_back(pixels("sharpened", [](cv::Mat& m) {
    cv::Mat soft;
    cv::GaussianBlur(m, soft, {}, 1.5);
    cv::addWeighted(m, 2.2, soft, -1.2, 0, m);
  }));
  list.push_back(pixels("JPEG 60", [](cv::Mat& m) { compress(m, 60); }));
  list.push_back(pixels("JPEG 25", [](cv::Mat& m) { compress(m, 25); }));
  list.push_back(pixels("warm light", [](cv::Mat& m) { cv::multiply(m, cv::Scalar(0.75, 0.95, 1.1), m); }));
  list.push_back(pixels("hue +25 deg", [](cv::Mat& m) { turn_hue(m, 12); }, false));
  list.push_back(pixels("grey", [](cv::Mat& m) { cv::cvtColor(m, m, cv::COLOR_BGR2GRAY), cv::cvtColor(m, m, cv::COLOR_GRAY2BGR); }, false));
  list.push_back(pixels("negative", [](cv::Mat& m) { cv::bitwise_not(m, m); }, false));
  list.push_back(moved("seen at an angle",
                       [](cv::Size s) { return std::pair(cv::Matx33d(1, 0, 0, 0, 1, 0, 0.12 / s.width, 0.08 / s.height, 1), s); }));
  list.push_back({"d 34, noise 8, JPEG 60, dim", [](const Scene& scene) {
                    Scene out = with_diameter(scene, 34);
                    out.bgr.convertTo(out.bgr, -1, 0.7, 0), add_noise(out.bgr, 8, 3), compress(out.bgr, 60);
                    return out;
                  }});
  list.push_back({"d 20, noise 4, blur 0.7", [](const Scene& scene) {
                    Scene out = with_diameter(scene, 20);
                    cv::GaussianBlur(out.bgr, out.bgr, {}, 0.7), add_noise(out.bgr, 4, 4);
                    return out;
                  }});
  return list;
}

Scene collage(const std::vector<Scene>& cut_from, const Collage& options) {
  std::mt19937 random(options.seed);
  const auto unit = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
  Scene out{"collage on " + options.table, cv::Mat(options.height_px, options.width_px, CV_8UC3), {}};
  for (int y = 0; y < out.bgr.rows; ++y)
    for (int x = 0; x < out.bgr.cols; ++x) {
      const cv::Vec3d colour = table_colour(options.table, x, y, options.diameter_px, random);
      for (int c = 0; c < 3; ++c) out.bgr.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(colour[c]);
    }
  const double r_px = options.diameter_px / 2;
  if (options.table == "speckle")
    for (int i = 0; i < options.width_px * options.height_px / 300; ++i)
      cv::circle(out.bgr, cv::Point2d(unit() * options.width_px, unit() * options.height_px), 1 + static_cast<int>(unit() * r_px * 0.4),
                 cv::Scalar::all(90 + 120 * unit()), cv::FILLED, cv::LINE_AA);
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
      cv::polylines(out.bgr, cable, false, cv::Scalar::all(25), std::max(1, static_cast<int>(r_px * (0.2 + 0.25 * i))), cv::LINE_AA);
    }
    for (int i = 0; i < 6; ++i)
      cv::circle(out.bgr, anywhere(), static_cast<int>(r_px * (0.55 + 0.05 * i)), cv::Scalar(70 + 10 * i, 110 + 5 * i, 130), cv::FILLED,
                 cv::LINE_AA);
    for (int i = 0; i < 20; ++i)
      cv::circle(out.bgr, anywhere(), std::max(1, static_cast<int>(r_px * 0.15)), cv::Scalar::all(255), cv::FILLED, cv::LINE_AA);
    cv::circle(out.bgr, anywhere(), static_cast<int>(2.2 * r_px), cv::Scalar(45, 60, 30), cv::FILLED, cv::LINE_AA);
  }

  // Places: anywhere, or beside a robot already there, never overlapping.
  for (int tries = 0; static_cast<int>(out.robots.size()) < options.robots && tries < 300000; ++tries) {
    const Scene& from = cut_from[random() % cut_from.size()];
    const TrueRobot& robot = from.robots[random() % from.robots.size()];
    cv::Point2d at(r_px * 1.2 + unit() * (options.width_px - 2.4 * r_px), r_px * 1.2 + unit() * (options.height_px - 2.4 * r_px));
    if (options.touching && !out.robots.empty() && unit() < 0.8) {
      const TrueRobot& beside = out.robots[random() % out.robots.size()];
      const double angle = unit() * 2 * std::numbers::pi;
      at = {beside.x_px + 2.02 * r_px * std::cos(angle), beside.y_px + 2.02 * r_px * std::sin(angle)};
    }
    if (at.x < 1.2 * r_px || at.y < 1.2 * r_px || at.x > options.width_px - 1.2 * r_px || at.y > options.height_px - 1.2 * r_px) continue;
    if (std::any_of(out.robots.begin(), out.robots.end(),
                    [&](const TrueRobot& other) { return std::hypot(other.x_px - at.x, other.y_px - at.y) < 2.01 * r_px; }))
      continue;
    // one neighbour in the source would be cut along with it
    if (std::any_of(from.robots.begin(), from.robots.end(), [&](const TrueRobot& other) {
          const double far = std::hypot(other.x_px - robot.x_px, other.y_px - robot.y_px);
          return far > 0 && far < 2.15 * robot.r_px;
        })) continue;
    const double scale = r_px / robot.r_px, turn = unit() * 2 * std::numbers::pi, c = scale * std::cos(turn), d = scale * std::sin(turn);
    const cv::Matx23d move(c, -d, at.x - c * robot.x_px + d * robot.y_px, d, c, at.y - d * robot.x_px - c * robot.y_px);
    const int left = static_cast<int>(at.x - 1.3 * r_px), top = static_cast<int>(at.y - 1.3 * r_px),
              side = static_cast<int>(2.6 * r_px) + 1;
    cv::Matx23d local = move;
    local(0, 2) -= left, local(1, 2) -= top;
    // Only round the robot; what shrinks is averaged first.
    const int half = static_cast<int>(1.5 * robot.r_px) + 4;
    const cv::Rect part = cv::Rect(static_cast<int>(robot.x_px) - half, static_cast<int>(robot.y_px) - half, 2 * half, 2 * half) &
                          cv::Rect({}, from.bgr.size());
    for (int i = 0; i < 2; ++i) local(i, 2) += local(i, 0) * part.x + local(i, 1) * part.y;
    cv::Mat patch, soft = from.bgr(part).clone();
    if (scale < 0.8) cv::GaussianBlur(soft, soft, {}, 0.4 / scale);
    cv::warpAffine(soft, patch, local, cv::Size(side, side), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    const cv::Rect all(0, 0, out.bgr.cols, out.bgr.rows);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        if (!all.contains(cv::Point(left + x, top + y))) continue;
        const double far = std::hypot(left + x - at.x, top + y - at.y), cover = std::clamp(r_px * 1.01 - far + 0.5, 0.0, 1.0);
        // a soft shadow beside the robot
        const double shade =
            1 - 0.25 * std::clamp(1.25 - std::hypot(left + x - at.x - 0.12 * r_px, top + y - at.y - 0.12 * r_px) / r_px, 0.0, 1.0);
        cv::Vec3b& pixel = out.bgr.at<cv::Vec3b>(top + y, left + x);
        for (int k = 0; k < 3; ++k)
          pixel[k] = cv::saturate_cast<std::uint8_t>(cover * patch.at<cv::Vec3b>(y, x)[k] + (1 - cover) * shade * pixel[k]);
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
