// Parts of an entity of Foxglove's 3D scene. Places in metres of the arena; nothing lies further off than max_place_m.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "foxglove.pb.h"

namespace arkmesh::recording::scene {

inline constexpr double max_place_m = 1000;
inline constexpr double drawn_height_m = 0.03;  // of obstacles, and of words above the floor

struct Colour {
  double r = 0, g = 0, b = 0, a = 1;
};
struct Point {
  double x = 0, y = 0, z = 0;
};

// To a hundredth of a millimetre; 0 for what is no place to draw at.
double place(double metres);
void set_pose(foxglove::Pose& to, const Point& at, double heading_rad = 0);
void set_colour(foxglove::Color& to, const Colour& colour);
void add_cylinder(foxglove::SceneEntity& to, double x, double y, double radius, double height, const Colour& colour);
void add_line(foxglove::SceneEntity& to, foxglove::LinePrimitive::Type type, std::span<const Point> points,
              const Colour& colour);
// `colours`: one for each point, or none for all of them in `colour`.
void add_triangles(foxglove::SceneEntity& to, std::span<const Point> points, std::span<const std::uint32_t> indices,
                   const Colour& colour, std::span<const Colour> colours = {});
void add_words(foxglove::SceneEntity& to, double x, double y, std::string_view text, const Colour& colour);

}  // namespace arkmesh::recording::scene
