// The tables of the real pictures, emptied, or of another colour and pattern.
#pragma once

#include <string>

#include "tests/support/pictures/robot_pictures.hpp"

namespace arkmesh::tests {

// The same table without its robots.
Scene emptied(const Scene& scene);
// The real robots and their shadows on a table of another colour and pattern, see table_colour.
Scene on_arena(const Scene& scene, const std::string& table);

// light, dark, grey (the boards' own), black, white, wood, parquet, felt, blue, checks, lines, print, carpet; textures
// have the size of robots' parts, where they hurt. `random` is a number 0..1 that differs from pixel to pixel.
cv::Vec3d table_colour(const std::string& table, double x, double y, double robot_px, double random);

}  // namespace arkmesh::tests
