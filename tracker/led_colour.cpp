// See led_colour.hpp.
#include "tracker/led_colour.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace arkmesh::tracker {
namespace {

// A sector of the colour circle, in degrees of hue. Blue reaches far towards violet: cameras see the blue LED there.
struct Sector {
  double from_deg, to_deg;
  hal::Led led;
};
constexpr std::array<Sector, 7> sectors{{{-25, 25, hal::Led::red},
                                         {25, 75, hal::Led::yellow},
                                         {75, 168, hal::Led::green},
                                         {168, 204, hal::Led::cyan},
                                         {204, 287, hal::Led::blue},
                                         {287, 335, hal::Led::magenta},
                                         {335, 385, hal::Led::red}}};
constexpr double least_saturation = 0.165;  // paler light is white

}  // namespace

LedColour led_colour(const Light& added) {
  const double most = std::max({added.blue, added.green, added.red, 0.0});
  const double least = std::clamp(std::min({added.blue, added.green, added.red}), 0.0, most);
  if (most <= 0) return {hal::Led::white, 0};
  const double saturation = (most - least) / most;
  const auto sure = [](double distance, double enough) { return static_cast<float>(std::clamp(distance / enough, 0.0, 1.0)); };
  if (saturation < least_saturation) return {hal::Led::white, sure(least_saturation - saturation, 0.08)};

  double hue_deg = 0;
  if (most == added.red) hue_deg = 60 * (added.green - std::max(added.blue, 0.0)) / (most - least);
  else if (most == added.green) hue_deg = 120 + 60 * (added.blue - added.red) / (most - least);
  else hue_deg = 240 + 60 * (added.red - added.green) / (most - least);
  for (const Sector& sector : sectors) {
    if (hue_deg < sector.from_deg || hue_deg >= sector.to_deg) continue;
    const double inside_deg = std::min(hue_deg - sector.from_deg, sector.to_deg - hue_deg);
    return {sector.led, std::min(sure(inside_deg, 15), sure(saturation - least_saturation, 0.08))};
  }
  return {hal::Led::red, 0};
}

}  // namespace arkmesh::tracker
