#include "recording/export/scene_parts.hpp"

#include <cmath>
#include <numbers>

namespace arkmesh::recording::scene {

using nlohmann::json;

double place(double metres) {
  return std::abs(metres) <= max_place_m ? std::round(metres * 1e5) / 1e5 : 0;
}

json in_json(const Colour& c) {
  return {{"r", c.r}, {"g", c.g}, {"b", c.b}, {"a", c.a}};
}

json point(double x, double y, double z) {
  return {{"x", x}, {"y", y}, {"z", z}};
}

json pose(double x, double y, double z, double heading_rad) {
  return {{"position", point(x, y, z)},
          {"orientation", {{"x", 0}, {"y", 0}, {"z", std::sin(heading_rad / 2)}, {"w", std::cos(heading_rad / 2)}}}};
}

json cylinder(double x, double y, double radius, double height, const Colour& colour) {
  return {{"pose", pose(x, y, height / 2)},
          {"size", point(2 * radius, 2 * radius, height)},
          {"bottom_scale", 1},
          {"top_scale", 1},
          {"color", in_json(colour)}};
}

json line(int type, const json& points, const Colour& colour) {
  constexpr double line_px = 2;
  return {{"type", type},     {"pose", pose(0, 0, 0)},    {"thickness", line_px},    {"scale_invariant", true},
          {"points", points}, {"color", in_json(colour)}, {"colors", json::array()}, {"indices", json::array()}};
}

json circle(double x, double y, double radius, double z, const Colour& colour) {
  json points = json::array();
  constexpr int corners = 36;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    points.push_back(point(x + radius * std::cos(angle), y + radius * std::sin(angle), z));
  }
  return line(loop, points, colour);
}

json triangles(const json& points, const json& indices, const Colour& colour, const json& colours) {
  return {{"pose", pose(0, 0, 0)},
          {"points", points},
          {"color", in_json(colour)},
          {"colors", colours},
          {"indices", indices}};
}

json words(double x, double y, std::string_view text, const Colour& colour) {
  return {{"pose", pose(x, y, robot_height_m)}, {"billboard", true}, {"font_size", 12}, {"scale_invariant", true},
          {"color", in_json(colour)},           {"text", text}};
}

}  // namespace arkmesh::recording::scene
