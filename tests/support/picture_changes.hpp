// What may happen to a picture of robots on its way to the detector: other light, other cameras, other tables.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/support/robot_pictures.hpp"

namespace arkmesh::tests {

struct PictureChange {
  std::string name;
  std::function<Scene(const Scene&)> make;
  bool keeps_colours = true;  // of the LEDs
};

// Turned, mirrored, brighter, darker, uneven light, noise, blur, compression, other hue, negative, seen at an angle.
std::vector<PictureChange> picture_changes();

// Robots cut from the real pictures and put on another table.
struct Collage {
  int width_px = 1024, height_px = 768, robots = 40;
  double diameter_px = 32;
  std::string table = "light";  // light, dark, black, wood, felt, checks, speckle
  bool touching = false;        // many in clusters
  bool distractors = false;     // coins, cables, paper, glints, a larger round board
  double noise = 2;             // standard deviation, grey levels
  unsigned seed = 1;
};
Scene collage(const std::vector<Scene>& cut_from, const Collage& options);

}  // namespace arkmesh::tests
