// Tells the eight colours of a robot's LED apart from the light it adds to its surroundings, not from its core, which
// is often saturated to white.
#pragma once

#include "hal/types.hpp"

namespace arkmesh::tracker {

// Light in linear or display units, whatever the scale; only ratios count.
struct Light {
  double blue = 0, green = 0, red = 0;
};

struct LedColour {
  hal::Led led = hal::Led::off;
  float confidence = 0;  // 0 at the border between two colours, 1 in the middle of one
  double hue_deg = 0;    // [-25, 335); 0 for light without hue
};

// The colour of light that an LED adds; never off. All channels zero is white with confidence 0.
LedColour led_colour(const Light& added);

}  // namespace arkmesh::tracker
