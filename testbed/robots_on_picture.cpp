// See robots_on_picture.hpp.
#include "testbed/robots_on_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "hal/counted.hpp"
#include "hal/overlay/led_name.hpp"
#include "tracker/brush.hpp"
#include "tracker/detect/detector.hpp"
#include "tracker/detect/led_neighbours.hpp"

namespace arkmesh::testbed {
namespace {

// Thousandths of a pixel say enough; what is not a number is null.
nlohmann::json number(double value, double steps) {
  if (!std::isfinite(value)) return nullptr;
  return std::round(value * steps) / steps;
}

cv::Scalar colour_of(hal::Led led) {
  if (led == hal::Led::unknown) return cv::Scalar::all(150);
  const int bits = static_cast<int>(led);
  return led == hal::Led::off ? cv::Scalar(0, 140, 255)
                              : cv::Scalar(bits & 4 ? 255 : 0, bits & 2 ? 255 : 0, bits & 1 ? 255 : 0);
}

}  // namespace

std::string nothing_found(double diameter_px) {
  const tracker::DetectorSettings all;
  const std::string range = fmt::format("{:g} to {:g} px across", all.smallest_diameter_px, all.largest_diameter_px);
  return diameter_px > 0
             ? fmt::format("no robot of about {:g} px across was found; without --diameter the search covers {}",
                           diameter_px, range)
             : fmt::format("no robot was found; the search covered {}: give their size with --diameter", range);
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

cv::Mat explained(const cv::Mat& bgr, const std::vector<tracker::Detection>& robots,
                  const tracker::Explanation& explanation) {
  // Small pictures are enlarged, so that words have room.
  const double scale = std::clamp(1400.0 / bgr.cols, 1.0, 4.0), text_px = 13;
  cv::Mat picture;
  cv::resize(bgr, picture, {}, scale, scale, cv::INTER_NEAREST);
  const auto ring = [&](const tracker::Circle& at, double part, const cv::Scalar& colour, int thick) {
    const auto fine = [&](double px) { return static_cast<int>(std::lround(16 * ((px + 0.5) * scale - 0.5))); };
    cv::circle(picture, {fine(at.x_px), fine(at.y_px)}, static_cast<int>(std::lround(16 * part * at.r_px * scale)),
               colour, thick, cv::LINE_AA, 4);
  };
  const auto label = [&](const std::string& words, double x_px, double y_px, const cv::Scalar& colour) {
    tracker::write(picture, words, {x_px * scale, y_px * scale}, text_px, colour);
  };
  const cv::Scalar found(90, 230, 90), cell(230, 200, 60), orange(40, 140, 255), white(255, 255, 255);
  for (const tracker::Explanation::NotFound& one : explanation.not_found) {
    ring(one.circle, 1, orange, 1);
    // where robots are found, what is hardly like one gets no words
    if (one.confidence < 0.02 && !robots.empty()) continue;
    label(fmt::format("{:.2f} {}", one.confidence, one.objection), one.circle.x_px + 0.8 * one.circle.r_px,
          one.circle.y_px - 0.7 * one.circle.r_px, orange);
  }
  for (const tracker::Detection& robot : robots) {
    const tracker::Circle at{robot.x_px, robot.y_px, robot.r_px};
    ring(at, 1, found, 2);
    ring(at, tracker::usual_cell, cell, 1);
    for (const double part : {tracker::nearest_led, tracker::farthest_led}) ring(at, part, white, 1);
    if (std::isfinite(robot.led_x_px))
      ring({robot.led_x_px, robot.led_y_px, robot.r_px}, 0.18, colour_of(robot.led), 2);
    label(fmt::format("{:.2f} {}", robot.confidence, hal::name_of(robot.led)), at.x_px - at.r_px,
          at.y_px + 1.2 * at.r_px + text_px / scale, found);
  }
  std::vector<std::string> lines{
      fmt::format("{} found (green: rim and confidence; blue: usual cell; white: where an LED can be)", robots.size()),
      fmt::format("{} rejected (orange: confidence and main reason)", explanation.not_found.size())};
  if (explanation.cells_first) lines.push_back("the coin cells were found first, then the bodies around them");
  for (std::size_t i = 0; i < std::min<std::size_t>(explanation.sizes.size(), 5); ++i)
    lines.push_back(fmt::format("{} {:.1f} px across: {:.2f}", i == 0 ? "evidence for the size:" : "then",
                                2 * explanation.sizes[i].r_px, explanation.sizes[i].votes));
  for (std::size_t i = 0; i < lines.size(); ++i)
    tracker::write(picture, lines[i], {6, text_px * 1.4 * static_cast<double>(i + 1)}, text_px, white);
  return picture;
}

}  // namespace arkmesh::testbed
