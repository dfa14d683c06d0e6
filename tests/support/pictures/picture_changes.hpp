// What may happen to a picture of robots on its way to the detector: a list of changes, each with a name.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/support/pictures/robot_pictures.hpp"

namespace arkmesh::tests {

struct PictureChange {
  std::string name;
  std::function<Scene(const Scene&)> make;
  bool keeps_colours = true;  // of the LEDs
};

// Turned, mirrored, brighter, darker, uneven light, noise, blur, compression, other hue, negative, seen at an angle.
std::vector<PictureChange> picture_changes();

}  // namespace arkmesh::tests
