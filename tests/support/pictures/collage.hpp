// Arenas that nobody photographed: robots cut from real pictures, turned and put elsewhere.
#pragma once

#include <string>
#include <vector>

#include "tests/support/pictures/robot_pictures.hpp"

namespace arkmesh::tests {

// Robots cut from the real pictures and put on another arena.
struct Collage {
  int width_px = 1024, height_px = 768, robots = 40;
  double diameter_px = 32;
  std::string arena = "light";  // speckle, or one of arena_colour
  bool touching = false;        // many in clusters
  bool distractors = false;     // coins, cables, paper, glints, a larger round board
  double noise = 2;             // standard deviation, grey levels
  unsigned seed = 1;
};
Scene collage(const std::vector<Scene>& cut_from, const Collage& options);

}  // namespace arkmesh::tests
