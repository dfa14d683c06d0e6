// See led_colour.hpp.
#include "tracker/detect/led_colour.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace arkmesh::tracker {
namespace {

// A sector of the colour circle, in degrees of hue. Blue reaches far towards violet: cameras see the blue LED there.
// Light paler than min_saturation is white; a little red, green or blue is enough, because light meant to be white is
// rarely tinted so.
struct Sector {
  double from_deg, to_deg;
  double min_saturation;
  hal::Led led;
};
constexpr std::array<Sector, 7> sectors{{{-25, 25, 0.12, hal::Led::red},
                                         {25, 75, 0.20, hal::Led::yellow},
                                         {75, 168, 0.09, hal::Led::green},
                                         {168, 204, 0.18, hal::Led::cyan},
                                         {204, 295, 0.11, hal::Led::blue},
                                         {295, 335, 0.18, hal::Led::magenta},
                                         {335, 385, 0.12, hal::Led::red}}};

}  // namespace

LedColour led_colour(const Light& added) {
  // an LED takes no light away
  const double blue = std::max(added.blue, 0.0), green = std::max(added.green, 0.0), red = std::max(added.red, 0.0);
  const double most = std::max({blue, green, red}), span = most - std::min({blue, green, red});
  if (!(most > 0)) return {hal::Led::white, 0};
  if (span < 1e-9 * most) return {hal::Led::white, 1};
  const double saturation = span / most;
  const auto sure = [](double distance, double enough) {
    return static_cast<float>(std::clamp(distance / enough, 0.0, 1.0));
  };
  double hue_deg = 0;
  if (most == red)
    hue_deg = 60 * (green - blue) / span;
  else if (most == green)
    hue_deg = 120 + 60 * (blue - red) / span;
  else
    hue_deg = 240 + 60 * (red - green) / span;
  if (hue_deg < -25) hue_deg += 360;
  for (const Sector& sector : sectors) {
    if (hue_deg < sector.from_deg || hue_deg >= sector.to_deg) continue;
    if (saturation < sector.min_saturation)
      return {hal::Led::white, sure(sector.min_saturation - saturation, 0.08), hue_deg};
    const double inside_deg = std::min(hue_deg - sector.from_deg, sector.to_deg - hue_deg);
    return {sector.led, std::min(sure(inside_deg, 15), sure(saturation - sector.min_saturation, 0.08)), hue_deg};
  }
  return {hal::Led::white, 0};
}

}  // namespace arkmesh::tracker
