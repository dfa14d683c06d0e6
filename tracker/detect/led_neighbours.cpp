// See led_neighbours.hpp.
#include "tracker/detect/led_neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace arkmesh::tracker {
namespace {

// Hues within a group of equal LEDs of one real picture differ by up to 10 degrees from the next one; blue and magenta
// are 60 degrees apart in theory, and 30 or more in pictures of both.
constexpr double gap_deg = 15;
// In theory the border is at 270 degrees; blue LEDs are seen at 223 to 254 on real arenas.
constexpr double border_deg = 270;

// LEDs lie at 0.81 to 0.96 of the radius, mirrored light at 0.5 to 0.9, on one side of most robots of a picture.
// Measured on the real pictures and on 17 of another room.
constexpr double beyond_glare = 0.92, glare_width_rad = 0.8;

bool blue_or_magenta(const Detection& robot) {
  return robot.led == hal::Led::blue || robot.led == hal::Led::magenta;
}

}  // namespace

void judge_beside_others(std::span<Detection*> robots) {
  std::vector<Detection*> lit;
  std::copy_if(robots.begin(), robots.end(), std::back_inserter(lit),
               [](const Detection* robot) { return blue_or_magenta(*robot); });
  std::stable_sort(lit.begin(), lit.end(),
                   [](const Detection* a, const Detection* b) { return a->led_hue_deg < b->led_hue_deg; });
  for (auto first = lit.begin(); first != lit.end();) {
    auto last = first + 1;
    while (last != lit.end() && (*last)->led_hue_deg - last[-1]->led_hue_deg < gap_deg) ++last;
    const double below = first == lit.begin() ? 2 * gap_deg : (*first)->led_hue_deg - first[-1]->led_hue_deg;
    const double above = last == lit.end() ? 2 * gap_deg : (*last)->led_hue_deg - last[-1]->led_hue_deg;
    if (const auto members = last - first; members >= 2) {
      const double median_deg = first[members / 2]->led_hue_deg;
      const hal::Led led = median_deg < border_deg ? hal::Led::blue : hal::Led::magenta;
      // as sure as the group stands apart
      const auto apart = static_cast<float>(std::min({below, above, 2 * gap_deg}) / (2 * gap_deg));
      for (; first != last; ++first) {
        if ((*first)->led == led) continue;
        (*first)->led = led;
        (*first)->led_confidence = std::min((*first)->led_lit_confidence, apart);
      }
    }
    first = last;
  }
}

void forget_led(Detection& robot) {
  robot.led = hal::Led::unknown;
  robot.led_confidence = robot.led_lit_confidence = 0;
  robot.led_hue_deg = 0;
  robot.led_x_px = robot.led_y_px = std::numeric_limits<double>::quiet_NaN();
}

void doubt_white(std::span<Detection*> robots) {
  const auto far = [](const Detection& robot) {
    return std::hypot(robot.led_x_px - robot.x_px, robot.led_y_px - robot.y_px) / robot.r_px;
  };
  const auto direction = [](const Detection& robot) {
    return std::atan2(robot.led_y_px - robot.y_px, robot.led_x_px - robot.x_px);
  };
  double x = 0, y = 0;
  int mirrored = 0;
  for (const Detection* robot : robots)
    if (robot->led == hal::Led::white && far(*robot) < nearest_led)
      x += std::cos(direction(*robot)), y += std::sin(direction(*robot)), ++mirrored;
  for (Detection* robot : robots) {
    if (robot->led != hal::Led::white) continue;
    const double off = std::abs(std::remainder(direction(*robot) - std::atan2(y, x), 2 * std::numbers::pi));
    if (robot->led_confidence < least_sure || far(*robot) < nearest_led ||
        (mirrored >= 2 && far(*robot) < beyond_glare && off < glare_width_rad))
      forget_led(*robot);
  }
}

}  // namespace arkmesh::tracker
