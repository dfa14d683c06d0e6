// See robots_on_picture.hpp.
#include "testbed/robots_on_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "hal/counted.hpp"
#include "hal/led_name.hpp"
#include "tracker/detect/detector.hpp"

namespace arkmesh::testbed {
namespace {

// Thousandths of a pixel say enough; what is not a number is null.
nlohmann::json number(double value, double steps) {
  if (!std::isfinite(value)) return nullptr;
  return std::round(value * steps) / steps;
}

cv::Scalar colour_of(hal::Led led) {
  const int bits = static_cast<int>(led);
  return led == hal::Led::off ? cv::Scalar(0, 140, 255)
                              : cv::Scalar(bits & 4 ? 255 : 0, bits & 2 ? 255 : 0, bits & 1 ? 255 : 0);
}

}  // namespace

std::string nothing_found(double diameter_px) {
  const tracker::DetectorSettings all;
  const std::string range = fmt::format("{:g} to {:g} px across", all.smallest_diameter_px, all.largest_diameter_px);
  return diameter_px > 0
             ? fmt::format("no robot of about {:g} px across was found; without --diameter those of {} are looked for",
                           diameter_px, range)
             : fmt::format("no robot was found; those of {} were looked for: tell their size with --diameter", range);
}

double led_heading_rad(const tracker::Detection& robot) {
  if (robot.led == hal::Led::off) return std::numeric_limits<double>::quiet_NaN();
  return std::atan2(-(robot.led_y_px - robot.y_px), robot.led_x_px - robot.x_px);
}

double heading_rad(const tracker::Detection& robot, double led_offset_rad) {
  const double heading = std::remainder(led_heading_rad(robot) + led_offset_rad, 2 * std::numbers::pi);
  return heading <= -std::numbers::pi ? std::numbers::pi : heading;
}

nlohmann::json robots_as_json(const std::vector<tracker::Detection>& robots, double led_offset_rad) {
  nlohmann::json list = nlohmann::json::array();
  for (const tracker::Detection& robot : robots)
    list.push_back({{"x_px", number(robot.x_px, 1e3)},
                    {"y_px", number(robot.y_px, 1e3)},
                    {"r_px", number(robot.r_px, 1e3)},
                    {"led", hal::name_of(robot.led)},
                    {"led_x_px", number(robot.led_x_px, 1e3)},
                    {"led_y_px", number(robot.led_y_px, 1e3)},
                    {"heading_rad", number(heading_rad(robot, led_offset_rad), 1e5)},
                    {"led_heading_rad", number(led_heading_rad(robot), 1e5)}});
  return list;
}

std::string robots_as_text(const std::vector<tracker::Detection>& robots, double led_offset_rad) {
  std::string text = fmt::format("{}\n", hal::counted(robots.size(), "robot"));
  if (!robots.empty()) text += "     x px     y px    r px  sure  LED      heading deg\n";
  for (const tracker::Detection& robot : robots) {
    const double heading = heading_rad(robot, led_offset_rad);
    text += fmt::format("{:9.2f}{:9.2f}{:8.2f}  {:.2f}  {:8} {}\n", robot.x_px, robot.y_px, robot.r_px,
                        robot.confidence, hal::name_of(robot.led),
                        std::isfinite(heading) ? fmt::format("{:11.1f}", heading * 180 / std::numbers::pi)
                                               : std::string("          -"));
  }
  return text;
}

cv::Mat with_robots_drawn(const cv::Mat& bgr, const std::vector<tracker::Detection>& robots, double led_offset_rad) {
  cv::Mat picture = bgr.clone();
  constexpr int shift = 4;  // circles and lines to a sixteenth of a pixel
  const auto fine = [](double x, double y) {
    return cv::Point(static_cast<int>(std::lround(x * 16)), static_cast<int>(std::lround(y * 16)));
  };
  for (const tracker::Detection& robot : robots) {
    const int thick = std::max(1, static_cast<int>(robot.r_px / 16));
    const cv::Scalar colour = colour_of(robot.led);
    cv::circle(picture, fine(robot.x_px, robot.y_px), static_cast<int>(std::lround(robot.r_px * 16)), colour, thick,
               cv::LINE_AA, shift);
    const double heading = heading_rad(robot, led_offset_rad);
    if (!std::isfinite(heading)) continue;
    cv::circle(picture, fine(robot.led_x_px, robot.led_y_px), static_cast<int>(std::lround(robot.r_px * 3)), colour,
               thick, cv::LINE_AA, shift);
    cv::line(picture, fine(robot.x_px, robot.y_px),
             fine(robot.x_px + 1.4 * robot.r_px * std::cos(heading), robot.y_px - 1.4 * robot.r_px * std::sin(heading)),
             colour, thick, cv::LINE_AA, shift);
  }
  return picture;
}

}  // namespace arkmesh::testbed
