// See photo_effects.hpp.
#include "tests/support/pictures/photo_effects.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

namespace arkmesh::tests {
namespace {

void look_up(cv::Mat& bgr, const std::function<double(double, int)>& of) {
  cv::Mat table(1, 256, CV_8UC3);
  for (int i = 0; i < 256; ++i)
    for (int c = 0; c < 3; ++c) table.at<cv::Vec3b>(i)[c] = cv::saturate_cast<std::uint8_t>(255 * of(i / 255.0, c));
  cv::LUT(bgr, table, bgr);
}

double linear(double shown) {
  return shown <= 0.04045 ? shown / 12.92 : std::pow((shown + 0.055) / 1.055, 2.4);
}
double shown(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double visible(const TrueRobot& robot, cv::Size size) {
  const double part_x =
      (std::min<double>(size.width, robot.x_px + robot.r_px) - std::max(0.0, robot.x_px - robot.r_px)) /
      (2 * robot.r_px);
  const double part_y =
      (std::min<double>(size.height, robot.y_px + robot.r_px) - std::max(0.0, robot.y_px - robot.r_px)) /
      (2 * robot.r_px);
  return std::max(0.0, std::min(part_x, part_y));
}

}  // namespace

void apply_gamma(cv::Mat& bgr, double gamma) {
  look_up(bgr, [gamma](double value, int) { return std::pow(value, gamma); });
}

void expose(cv::Mat& bgr, double stops) {
  look_up(bgr, [gain = std::pow(2, stops)](double value, int) { return shown(std::min(1.0, gain * linear(value))); });
}

void cast(cv::Mat& bgr, double blue, double green, double red) {
  const double gains[] = {blue, green, red};
  look_up(bgr, [&](double value, int c) { return shown(std::min(1.0, gains[c] * linear(value))); });
}

void multiply_by(cv::Mat& bgr, const std::function<double(double, double)>& gain) {
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const double by = gain(static_cast<double>(x) / bgr.cols, static_cast<double>(y) / bgr.rows);
      for (int c = 0; c < 3; ++c)
        bgr.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(by * bgr.at<cv::Vec3b>(y, x)[c]);
    }
}

void vignette(cv::Mat& bgr, double corner) {
  multiply_by(bgr, [corner](double x, double y) {
    return 1 - (1 - corner) * 2 * ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5));
  });
}

void add_noise(cv::Mat& bgr, double deviation, unsigned seed) {
  cv::RNG random(seed);
  cv::Mat noise(bgr.size(), CV_16SC3);
  random.fill(noise, cv::RNG::NORMAL, 0, deviation);
  cv::add(bgr, noise, bgr, cv::noArray(), CV_8UC3);
}

void add_salt(cv::Mat& bgr, double part, unsigned seed) {
  cv::RNG random(seed);
  for (int i = 0; i < static_cast<int>(part * bgr.rows * bgr.cols); ++i)
    bgr.at<cv::Vec3b>(random.uniform(0, bgr.rows), random.uniform(0, bgr.cols)) =
        cv::Vec3b::all(random.uniform(0, 2) ? 255 : 0);
}

void compress(cv::Mat& bgr, int quality) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  bgr = cv::imdecode(bytes, cv::IMREAD_COLOR);
}

void motion_blur(cv::Mat& bgr, double length_px, double angle_deg) {
  const int half = static_cast<int>(std::ceil(length_px / 2)), side = 2 * half + 1;
  cv::Mat kernel(side, side, CV_32F, cv::Scalar(0));
  const double angle = angle_deg * std::numbers::pi / 180;
  for (int i = -50; i <= 50; ++i) {
    const double far = i / 100.0 * length_px;
    kernel.at<float>(half + static_cast<int>(std::lround(far * std::sin(angle))),
                     half + static_cast<int>(std::lround(far * std::cos(angle)))) += 1.0F / 101;
  }
  cv::filter2D(bgr, bgr, -1, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
}

void turn_hue(cv::Mat& bgr, int half_degrees) {
  cv::Mat hsv;
  cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV);
  for (int y = 0; y < hsv.rows; ++y)
    for (int x = 0; x < hsv.cols; ++x)
      hsv.at<cv::Vec3b>(y, x)[0] = static_cast<std::uint8_t>((hsv.at<cv::Vec3b>(y, x)[0] + half_degrees + 180) % 180);
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
}

Scene recoloured(const Scene& scene, hal::Led led, std::size_t every) {
  Scene out{scene.name, scene.bgr.clone(), scene.robots, scene.also};
  std::size_t blue = 0;
  for (TrueRobot& robot : out.robots) {
    if (robot.led != hal::Led::blue || blue++ % every != 0) continue;
    robot.led = led;
    const int reach = static_cast<int>(0.7 * robot.r_px), bits = static_cast<int>(led);
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const cv::Point at(static_cast<int>(robot.led_x_px) + x, static_cast<int>(robot.led_y_px) + y);
        if (x * x + y * y > reach * reach || !cv::Rect({}, scene.bgr.size()).contains(at)) continue;
        cv::Vec3b& pixel = out.bgr.at<cv::Vec3b>(at);
        const int most = *std::max_element(pixel.val, pixel.val + 3),
                  least = *std::min_element(pixel.val, pixel.val + 3);
        for (int c = 0; c < 3; ++c)
          pixel[c] = static_cast<std::uint8_t>(bits & (c == 0 ? 4 : c == 1 ? 2 : 1) ? most : least);
      }
  }
  return out;
}

Scene with_glare(const Scene& scene, double levels) {
  Scene out{scene.name, scene.bgr.clone(), scene.robots, scene.also};
  for (const TrueRobot& robot : out.robots) {
    const double reach = 0.6 * robot.r_px;
    for (int y = static_cast<int>(robot.y_px - reach); y <= robot.y_px + reach; ++y)
      for (int x = static_cast<int>(robot.x_px - reach); x <= robot.x_px + reach; ++x) {
        const double far = std::hypot(x - robot.x_px, y - robot.y_px) / reach;
        if (far >= 1 || !cv::Rect({}, scene.bgr.size()).contains({x, y})) continue;
        for (std::uint8_t& value : out.bgr.at<cv::Vec3b>(y, x).val)
          value = cv::saturate_cast<std::uint8_t>(value + levels * (1 - far * far));
      }
  }
  return out;
}

Scene changed(const Scene& scene, const std::function<void(cv::Mat&)>& change) {
  Scene out{scene.name, scene.bgr.clone(), scene.robots, scene.also};
  change(out.bgr);
  return out;
}

Scene warped(const Scene& scene, const cv::Matx33d& move, cv::Size size, bool black_border) {
  Scene out{scene.name, {}, {}};
  cv::warpPerspective(scene.bgr, out.bgr, move, size, cv::INTER_AREA,
                      black_border ? cv::BORDER_CONSTANT : cv::BORDER_REPLICATE);
  const auto moved = [&](double x, double y) {
    const cv::Vec3d at = move * cv::Vec3d(x, y, 1);
    return cv::Point2d(at[0] / at[2], at[1] / at[2]);
  };
  for (const TrueRobot& robot : scene.robots) {
    const cv::Point2d at = moved(robot.x_px, robot.y_px), led = moved(robot.led_x_px, robot.led_y_px);
    const cv::Point2d right = moved(robot.x_px + robot.r_px, robot.y_px),
                      down = moved(robot.x_px, robot.y_px + robot.r_px);
    const TrueRobot there{at.x, at.y, (cv::norm(right - at) + cv::norm(down - at)) / 2, robot.led, led.x, led.y};
    const double seen = visible(there, size);
    if (seen > 0.999)
      out.robots.push_back(there);
    else if (seen > 0)
      out.also.push_back(there);
  }
  return out;
}

Scene turned(const Scene& scene, double angle_deg, bool black_border) {
  const double angle = angle_deg * std::numbers::pi / 180, c = std::cos(angle), d = std::sin(angle);
  const double wide = scene.bgr.cols, high = scene.bgr.rows;
  const int new_wide = static_cast<int>(std::abs(c) * wide + std::abs(d) * high),
            new_high = static_cast<int>(std::abs(d) * wide + std::abs(c) * high);
  const cv::Matx33d move(c, -d, new_wide / 2.0 - c * wide / 2 + d * high / 2, d, c,
                         new_high / 2.0 - d * wide / 2 - c * high / 2, 0, 0, 1);
  return warped(scene, move, cv::Size(new_wide, new_high), black_border);
}

Scene mirrored(const Scene& scene) {
  return warped(scene, cv::Matx33d(-1, 0, scene.bgr.cols - 1, 0, 1, 0, 0, 0, 1), scene.bgr.size());
}

Scene cropped(const Scene& scene, const cv::Rect& part, double visible_part) {
  const cv::Rect inside = part & cv::Rect({}, scene.bgr.size());
  Scene out{scene.name + " cut out", scene.bgr(inside).clone(), {}};
  for (TrueRobot robot : scene.robots) {
    robot.x_px -= inside.x, robot.led_x_px -= inside.x, robot.y_px -= inside.y, robot.led_y_px -= inside.y;
    const double seen = visible(robot, inside.size());
    if (seen >= visible_part)
      out.robots.push_back(robot);
    else if (seen > 0)
      out.also.push_back(robot);
  }
  return out;
}

std::vector<Scene> cut_outs(const std::vector<Scene>& scenes, int robots, int count, unsigned seed) {
  std::mt19937 random(seed);
  const auto unit = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
  std::vector<Scene> list;
  for (int tries = 0; static_cast<int>(list.size()) < count && tries < 100000; ++tries) {
    const Scene& scene = scenes[random() % scenes.size()];
    const TrueRobot& robot = scene.robots[random() % scene.robots.size()];
    const double wide = robot.r_px * (3.5 + 12 * unit()), high = robot.r_px * (3.5 + 12 * unit());
    const cv::Rect part(static_cast<int>(robot.x_px - wide * (0.15 + 0.7 * unit())),
                        static_cast<int>(robot.y_px - high * (0.15 + 0.7 * unit())), static_cast<int>(wide),
                        static_cast<int>(high));
    Scene one = cropped(scene, part);
    if (static_cast<int>(one.robots.size()) == robots && one.also.empty()) list.push_back(std::move(one));
  }
  return list;
}

std::vector<Scene> border_cuts(const std::vector<Scene>& scenes, double visible_part, int count, unsigned seed) {
  std::mt19937 random(seed);
  const auto unit = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
  std::vector<Scene> list;
  while (static_cast<int>(list.size()) < count) {
    const Scene& scene = scenes[1 + random() % (scenes.size() - 1)];
    const double wide = scene.bgr.cols * (0.4 + 0.3 * unit()), high = scene.bgr.rows * (0.4 + 0.3 * unit());
    const cv::Rect part(static_cast<int>(unit() * (scene.bgr.cols - wide)),
                        static_cast<int>(unit() * (scene.bgr.rows - high)), static_cast<int>(wide),
                        static_cast<int>(high));
    Scene one = cropped(scene, part, visible_part);
    if (one.robots.size() >= 3) list.push_back(std::move(one));
  }
  return list;
}

}  // namespace arkmesh::tests
