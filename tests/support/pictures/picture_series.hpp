// Everything the detector is tried with, as rows of a table: real pictures in other sizes, light, on other tables, cut,
// and crowded with things that are no robots.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/support/pictures/robot_pictures.hpp"

namespace arkmesh::tests {

struct PictureSeries {
  std::string group, name;
  std::function<std::vector<Scene>()> make;
  bool keeps_colours = true;  // of the LEDs
};

// Made of these scenes.
std::vector<PictureSeries> picture_series(const std::vector<Scene>& real);

}  // namespace arkmesh::tests
