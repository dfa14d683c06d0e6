// See led_neighbours.hpp.
#include "tracker/detect/led_neighbours.hpp"

#include <algorithm>
#include <vector>

namespace arkmesh::tracker {
namespace {

// Hues within a group of equal LEDs of one real picture differ by up to 10 degrees from the next one; blue and magenta
// are 60 degrees apart in theory, and 30 or more in pictures of both.
constexpr double gap_deg = 15;
// In theory the border is at 270 degrees; blue LEDs are seen at 223 to 254 on real tables.
constexpr double border_deg = 270;

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

}  // namespace arkmesh::tracker
