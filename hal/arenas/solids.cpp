#include "hal/arenas/solids.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <ranges>
#include <set>
#include <tuple>

#include "hal/arenas/arena_config.hpp"
#include "hal/fixed_math.hpp"

namespace arkmesh::hal {
namespace {

constexpr std::size_t most_obstacles = 1000, most_objects = 100, most_corners = 64;
constexpr double least_area_m2 = 1e-6;

double cross(const Point& o, const Point& a, const Point& b) {
  return (a.x_m - o.x_m) * (b.y_m - o.y_m) - (a.y_m - o.y_m) * (b.x_m - o.x_m);
}

double area_m2(const std::vector<Point>& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    twice += cross({0, 0}, corners[i], corners[(i + 1) % corners.size()]);
  return twice / 2;
}

// Whether two sides that share no corner meet.
bool crosses_itself(const std::vector<Point>& corners) {
  const std::size_t n = corners.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      const Point &a = corners[i], &b = corners[i + 1], &c = corners[j], &d = corners[(j + 1) % n];
      if (cross(a, b, c) * cross(a, b, d) <= 0 && cross(c, d, a) * cross(c, d, b) <= 0) return true;
    }
  return false;
}

// Of a polygon, counter-clockwise.
std::vector<Point> corners_in(const Section& s, const std::vector<double>& numbers) {
  if (numbers.size() % 2 != 0 || numbers.size() < 6 || numbers.size() > 2 * most_corners)
    s.refuse("corners", fmt::format("must hold x and y of 3 to {} corners", most_corners));
  std::vector<Point> out;
  for (std::size_t i = 0; i < numbers.size(); i += 2) out.push_back({numbers[i], numbers[i + 1]});
  if (crosses_itself(out)) s.refuse("corners", "make a polygon that crosses itself; list them in order around it");
  if (std::abs(area_m2(out)) < least_area_m2)
    s.refuse("corners", "make a polygon of less than a square millimetre; spread them, or draw a wall");
  if (area_m2(out) < 0) std::ranges::reverse(out);
  return out;
}

// A shape and where it lies, as people write it.
struct PlacedShape {
  enum class Kind { disc, box, polygon, wall } kind = Kind::disc;
  double x_m = 0, y_m = 0, heading_deg = 0;
  double radius_m = 0, length_m = 0, width_m = 0;
  std::vector<double> corners;
  Shape shape;  // by check()
  Pose pose;

  void fields(const Section& s) {
    s.field("shape", kind,
            {.help = "disc (radius_m), box (length_m, width_m), wall (a thin box) or polygon (corners)",
             .one_of = {"disc", "box", "polygon", "wall"}});
    s.field("x_m", x_m, {{-100, 100}, "m", "position of the centre; of a polygon, of the origin of its corners"});
    s.field("y_m", y_m, {{-100, 100}, "m", "position of the same point"});
    s.field("heading_deg", heading_deg, {{-360, 360}, "deg", "heading, counter-clockwise from +x"});
    s.field("radius_m", radius_m, {{0, 50}, "m", "radius of a disc"});
    s.field("length_m", length_m, {{0, 100}, "m", "length of a box or wall, along its heading"});
    s.field("width_m", width_m, {{0, 100}, "m", "width of a box, across its heading; of a wall, 0.01 unless given"});
    s.field("corners", corners, {{-100, 100}, "m", "corners of a polygon in its own frame: x, y of each"});
  }

  void check(const Section& s) {
    const bool box = kind == Kind::box || kind == Kind::wall;
    if (kind == Kind::wall && width_m == 0) width_m = 0.01;
    for (const auto& [key, belongs, given] :
         {std::tuple("radius_m", kind == Kind::disc, radius_m != 0), std::tuple("length_m", box, length_m != 0),
          std::tuple("width_m", box, width_m != 0), std::tuple("corners", kind == Kind::polygon, !corners.empty())}) {
      if (belongs && !given) s.refuse(key, "is missing; this shape needs it");
      if (!belongs && given) s.refuse(key, "does not belong to this shape; remove it, or choose another shape");
    }
    const double heading = heading_deg * std::numbers::pi / 180;
    pose = {x_m, y_m, std::remainder(heading, 2 * std::numbers::pi)};
    if (kind == Kind::disc) shape.radius_m = radius_m;
    if (box) {
      const double l = length_m / 2, w = width_m / 2;
      shape.corners = {{-l, -w}, {l, -w}, {l, w}, {-l, w}};
      if (length_m * width_m < least_area_m2)
        s.refuse("width_m", "makes it smaller than a square millimetre; make it larger");
    }
    if (kind == Kind::polygon) shape.corners = corners_in(s, corners);
  }
};

struct ObjectConfig : PlacedShape {
  std::string name;
  double mass_kg = 0.05, friction = 0.1;

  void fields(const Section& s) {
    s.field("name", name,
            {.help = "name of the object in scenarios and tables", .sample = "\"puck\"", .required = true});
    PlacedShape::fields(s);
    s.field("mass_kg", mass_kg, {{0.001, 100}, "kg", "total mass, evenly distributed"});
    s.field("friction", friction,
            {{0, 10}, "", "Coulomb friction with the table; with robots, arena.ode.friction applies"});
  }
};

// It stands in tables, where robots have numbers.
bool is_object_name(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !name.empty() && name.size() <= 31 && letter(name[0]) &&
         std::ranges::all_of(name, [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-'; });
}

struct SolidLists {
  std::vector<PlacedShape> obstacles;
  std::vector<ObjectConfig> objects;
  enum class ArenaShape { rectangle, round, polygon } shape = ArenaShape::rectangle;
  std::vector<double> corners;

  void fields(const Section& arena) {
    arena.field(
        "shape", shape,
        {.help = "rectangle: width_m x height_m; round: width_m across; polygon: corners, within that rectangle",
         .one_of = {"rectangle", "round", "polygon"}});
    arena.field("corners", corners, {{-100, 100}, "m", "corners of a polygonal arena: x, y of each"});
    arena.field("obstacles", obstacles);
    arena.field("objects", objects);
  }
};

// Empty: a rectangle.
std::vector<Point> rim_of(const Section& arena, const SolidLists& said) {
  constexpr int round_sides = 96;  // at most 0.6 mm inside a circle of 2 m
  const auto sides = arena.read<ArenaSides>();
  if (said.shape == SolidLists::ArenaShape::polygon) {
    const std::vector<Point> corners = corners_in(arena, said.corners);
    for (const Point& corner : corners)
      if (std::abs(corner.x_m) > sides.width_m / 2 || std::abs(corner.y_m) > sides.height_m / 2)
        arena.refuse("corners", fmt::format("must lie within width_m x height_m, {} m x {} m around the origin",
                                            sides.width_m, sides.height_m));
    return corners;
  }
  if (!said.corners.empty()) arena.refuse("corners", "belong to shape = \"polygon\"; remove them, or set that shape");
  std::vector<Point> out;
  if (said.shape == SolidLists::ArenaShape::rectangle) return out;
  if (sides.width_m != sides.height_m) arena.refuse("shape", "needs equal width_m and height_m");
  for (int i = 0; i < round_sides; ++i) {
    const double turn = 2 * std::numbers::pi * i / round_sides;
    out.push_back({sides.width_m / 2 * fixed::cos(turn), sides.width_m / 2 * fixed::sin(turn)});
  }
  return out;
}

// A wall outside of each side.
void add_rim(Solids& out) {
  constexpr double thick_m = 0.01;
  for (std::size_t i = 0; i < out.rim.size(); ++i) {
    const Point &a = out.rim[i], &b = out.rim[(i + 1) % out.rim.size()];
    const double x = b.x_m - a.x_m, y = b.y_m - a.y_m, length_m = std::sqrt(x * x + y * y),
                 out_x = y / length_m * thick_m, out_y = -x / length_m * thick_m;
    out.obstacles.push_back(
        {.shape = {.corners = {a, {a.x_m + out_x, a.y_m + out_y}, {b.x_m + out_x, b.y_m + out_y}, b}}, .pose = {}});
  }
}

}  // namespace

Solids read_solids(const Section& arena) {
  const auto lists = arena.read<SolidLists>();
  if (lists.obstacles.size() > most_obstacles)
    arena.refuse("obstacles", fmt::format("are {}; at most {} are possible", lists.obstacles.size(), most_obstacles));
  if (lists.objects.size() > most_objects)
    arena.refuse("objects", fmt::format("are {}; at most {} are possible", lists.objects.size(), most_objects));
  Solids out;
  for (const PlacedShape& one : lists.obstacles) out.obstacles.push_back({one.shape, one.pose});
  out.rim = rim_of(arena, lists);
  add_rim(out);
  std::set<std::string> names;
  for (std::size_t i = 0; i < lists.objects.size(); ++i) {
    const ObjectConfig& one = lists.objects[i];
    if (!is_object_name(one.name) || !names.insert(one.name).second)
      arena.section("objects", static_cast<int>(i))
          .refuse("name", "must be unique for each object: a letter, then letters, digits, '_' and '-'");
    out.objects.push_back({one.name, one.shape, one.pose, one.mass_kg, one.friction});
  }
  return out;
}

std::vector<KeyRow> solids_keys() {
  return keys_of<SolidLists>("arena");
}

}  // namespace arkmesh::hal
