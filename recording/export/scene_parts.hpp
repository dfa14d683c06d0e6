// Parts of an entity of Foxglove's 3D scene, as JSON. Places in metres of the arena; nothing lies further off than
// max_place_m.
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace arkmesh::recording::scene {

inline constexpr double max_place_m = 1000;
inline constexpr double robot_height_m = 0.03;  // of a Kilobot; no message tells it

struct Colour {
  double r = 0, g = 0, b = 0, a = 1;
};

struct Parts {
  nlohmann::json cylinders = nlohmann::json::array(), lines = nlohmann::json::array(),
                 triangles = nlohmann::json::array(), texts = nlohmann::json::array();
};

// To a hundredth of a millimetre; 0 for what is no place to draw at.
double place(double metres);
nlohmann::json in_json(const Colour& colour);
nlohmann::json point(double x, double y, double z);
nlohmann::json pose(double x, double y, double z, double heading_rad = 0);
nlohmann::json cylinder(double x, double y, double radius, double height, const Colour& colour);
// `type`: strip, loop or segments (LINE_STRIP, LINE_LOOP, LINE_LIST).
inline constexpr int strip = 0, loop = 1, segments = 2;
nlohmann::json line(int type, const nlohmann::json& points, const Colour& colour);
nlohmann::json circle(double x, double y, double radius, double z, const Colour& colour);
// `colours`: one for each point, or none for all of them in `colour`.
nlohmann::json triangles(const nlohmann::json& points, const nlohmann::json& indices, const Colour& colour,
                         const nlohmann::json& colours = nlohmann::json::array());
nlohmann::json words(double x, double y, std::string_view text, const Colour& colour);

}  // namespace arkmesh::recording::scene
