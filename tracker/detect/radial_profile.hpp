// What lies within a round edge and just outside it, in grey levels: a robot has a paler coin cell in a dark, motley
// board.
#pragma once

#include <array>

#include "tracker/detect/downsampled_image.hpp"

namespace arkmesh::tracker {

struct RadialProfile {
  // Mean grey level in rings round the centre; ring i reaches from 0.1 i to 0.1 (i + 1) of the radius.
  std::array<float, 13> rings{};
  float activity = 0;     // median deviation of the grey level within 0.9 of the radius
  float coin = 0;         // median within half the radius
  float coin_spread = 0;  // from its tenth to its nine tenths
  float board_low = 0, board = 0,
        board_high = 0;                     // tenth, half and nine tenths of the ring from 0.7 to 0.9 of the radius
  float outside_low = 0, outside_high = 0;  // tenth and nine tenths of the ring from 1.1 to 1.3 of the radius
};

// Of the circle round (x, y), all in pixels of the patch. Zeros where nothing of it lies in the patch.
RadialProfile radial_profile(const DownsampledImage& patch, float x, float y, float r);

}  // namespace arkmesh::tracker
