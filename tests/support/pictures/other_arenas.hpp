// The arenas of the real pictures, emptied, or of another colour and pattern.
#pragma once

#include <string>

#include "tests/support/pictures/robot_pictures.hpp"

namespace arkmesh::tests {

// The same arena without its robots.
Scene emptied(const Scene& scene);
// The real robots and their shadows on an arena of another colour and pattern, see arena_colour.
Scene on_arena(const Scene& scene, const std::string& arena);

// light, dark, grey (the boards' own), black, white, wood, parquet, felt, blue, checks, lines, print, carpet; textures
// have the size of robots' parts, where they hurt. `random` is a number 0..1 that differs from pixel to pixel.
cv::Vec3d arena_colour(const std::string& arena, double x, double y, double robot_px, double random);

}  // namespace arkmesh::tests
