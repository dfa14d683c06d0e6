#include "recording/export/scene_parts.hpp"

#include <cmath>
#include <string>

namespace arkmesh::recording::scene {

double place(double metres) {
  return std::abs(metres) <= max_place_m ? std::round(metres * 1e5) / 1e5 : 0;
}

void set_pose(foxglove::Pose& to, const Point& at, double heading_rad) {
  to.mutable_position()->set_x(at.x);
  to.mutable_position()->set_y(at.y);
  to.mutable_position()->set_z(at.z);
  to.mutable_orientation()->set_z(std::sin(heading_rad / 2));
  to.mutable_orientation()->set_w(std::cos(heading_rad / 2));
}

void set_colour(foxglove::Color& to, const Colour& c) {
  to.set_r(c.r);
  to.set_g(c.g);
  to.set_b(c.b);
  to.set_a(c.a);
}

void add_cylinder(foxglove::SceneEntity& to, double x, double y, double radius, double height, const Colour& colour) {
  foxglove::CylinderPrimitive& one = *to.add_cylinders();
  set_pose(*one.mutable_pose(), {x, y, height / 2});
  one.mutable_size()->set_x(2 * radius);
  one.mutable_size()->set_y(2 * radius);
  one.mutable_size()->set_z(height);
  one.set_bottom_scale(1);
  one.set_top_scale(1);
  set_colour(*one.mutable_color(), colour);
}

template <class To>
static void add_points(To& to, std::span<const Point> points) {
  for (const Point& each : points) {
    foxglove::Point3& one = *to.add_points();
    one.set_x(each.x);
    one.set_y(each.y);
    one.set_z(each.z);
  }
}

void add_line(foxglove::SceneEntity& to, foxglove::LinePrimitive::Type type, std::span<const Point> points,
              const Colour& colour) {
  foxglove::LinePrimitive& one = *to.add_lines();
  one.set_type(type);
  set_pose(*one.mutable_pose(), {});
  one.set_thickness(2);  // pixels
  one.set_scale_invariant(true);
  add_points(one, points);
  set_colour(*one.mutable_color(), colour);
}

void add_triangles(foxglove::SceneEntity& to, std::span<const Point> points, std::span<const std::uint32_t> indices,
                   const Colour& colour, std::span<const Colour> colours) {
  foxglove::TriangleListPrimitive& one = *to.add_triangles();
  set_pose(*one.mutable_pose(), {});
  add_points(one, points);
  set_colour(*one.mutable_color(), colour);
  for (const Colour& each : colours) set_colour(*one.add_colors(), each);
  one.mutable_indices()->Add(indices.begin(), indices.end());
}

void add_words(foxglove::SceneEntity& to, double x, double y, std::string_view text, const Colour& colour) {
  foxglove::TextPrimitive& one = *to.add_texts();
  set_pose(*one.mutable_pose(), {x, y, drawn_height_m});
  one.set_billboard(true);
  one.set_font_size(12);
  one.set_scale_invariant(true);
  set_colour(*one.mutable_color(), colour);
  one.set_text(std::string(text));
}

}  // namespace arkmesh::recording::scene
