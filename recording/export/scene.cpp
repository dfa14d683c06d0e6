#include "recording/export/scene.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "hal/overlay/drawing_message.hpp"
#include "recording/export/drawn_scene.hpp"
#include "recording/export/json.hpp"

namespace arkmesh::recording {
namespace {

using namespace hal::layout;

using nlohmann::json;
using namespace scene;

constexpr std::int64_t robots_every_us = 200'000;

constexpr Colour led_colours[9] = {{0.2, 0.2, 0.2}, {0.88, 0.19, 0.13}, {0.13, 0.63, 0.13},
                                   {0.82, 0.63, 0}, {0.19, 0.31, 0.88}, {0.88, 0.13, 0.88},
                                   {0, 0.69, 0.69}, {1, 1, 1},          {0.5, 0.5, 0.5}};
constexpr Colour wall{0.3, 0.3, 0.3}, obstacle{0.5, 0.45, 0.4};

// A number of a message, 0 when it is not there or no place to draw at.
double number(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? place(found->get<double>()) : 0;
}

const json& list(const json& object, const char* key) {
  static const json none = json::array();
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : none;
}

// Robots of a frame, which are many and often: written as text at once.
class RobotDrawing : public Visitor {
 public:
  explicit RobotDrawing(double radius_m) : radius_m_(radius_m) {}
  void value(const Field& field, const Value& value) override {
    if (depth_ == 0 && field.name == "part") part = value.integer;
    if (depth_ == 0) return;
    if (field.name == "x_m") x_ = near(value.real);
    if (field.name == "y_m") y_ = near(value.real);
    if (field.name == "heading_rad") heading_ = near(value.real);
    if (field.name == "led") led_ = std::min<std::size_t>(static_cast<std::size_t>(value.integer), 8);
  }
  void bytes(const Field&, std::span<const std::byte>) override {}
  void begin_list(const Field& field, std::size_t) override { is_robot_ = field.name == "robots"; }
  void end_list(const Field&) override {}
  void begin_record(const Field&, std::size_t) override { ++depth_; }
  void end_record(const Field&) override {
    --depth_;
    if (!is_robot_) return;
    const Colour& c = led_colours[led_];
    fmt::format_to(std::back_inserter(cylinders),
                   FMT_COMPILE("{}{{\"pose\":{{\"position\":{{\"x\":{:.5f},\"y\":{:.5f},\"z\":{}}},\"orientation\":{{"
                               "\"x\":0,\"y\":0,\"z\":0,\"w\":1}}}},"
                               "\"size\":{{\"x\":{},\"y\":{},\"z\":{}}},\"bottom_scale\":1,\"top_scale\":1,"
                               "\"color\":{{\"r\":{},\"g\":{},\"b\":{},\"a\":1}}}}"),
                   cylinders.empty() ? "" : ",", x_, y_, robot_height_m / 2, 2 * radius_m_, 2 * radius_m_,
                   robot_height_m, c.r, c.g, c.b);
    fmt::format_to(std::back_inserter(headings),
                   FMT_COMPILE("{}{{\"x\":{:.5f},\"y\":{:.5f},\"z\":{}}},{{\"x\":{:.5f},\"y\":{:.5f},\"z\":{}}}"),
                   headings.empty() ? "" : ",", x_, y_, heading_z, x_ + radius_m_ * std::cos(heading_),
                   y_ + radius_m_ * std::sin(heading_), heading_z);
  }

  std::int64_t part = 0;
  std::string cylinders, headings;

 private:
  static constexpr double heading_z = robot_height_m + 0.001;
  static double near(double value) { return std::abs(value) <= max_place_m ? value : 0; }

  int depth_ = 0;
  bool is_robot_ = false;
  const double radius_m_;
  double x_ = 0, y_ = 0, heading_ = 0;
  std::size_t led_ = 0;
};

// Robots of other labs, from the shared frame to this arena's.
Parts others_of(const json& view, const std::string& own, double robot_radius_m) {
  Parts out;
  const double scale = number(view, "scale"), turn = number(view, "turn_rad");
  if (scale <= 0) return out;
  for (const json& lab : list(view, "labs")) {
    if (lab.value("lab", "") == own) continue;
    for (const json& robot : list(lab, "robots")) {
      const double x = robot.value("x_um", 0) / 1e6 - number(view, "shift_x_m"),
                   y = robot.value("y_um", 0) / 1e6 - number(view, "shift_y_m");
      const double c = std::cos(turn), s = std::sin(turn);
      Colour colour = led_colours[std::clamp(robot.value("led", 0), 0, 8)];
      colour.a = 0.6;
      out.lines.push_back(circle((c * x + s * y) / scale, (c * y - s * x) / scale, robot_radius_m, 0.002, colour));
    }
  }
  return out;
}

Parts arena_of(const json& arena) {
  Parts out;
  const double x = number(arena, "width_m") / 2, y = number(arena, "height_m") / 2;
  out.lines.push_back(line(loop, {point(-x, -y, 0), point(x, -y, 0), point(x, y, 0), point(-x, y, 0)}, wall));
  const json& corners = list(arena, "corners");
  for (const json& solid : list(arena, "solids")) {
    if (number(solid, "mass_kg") > 0) continue;  // objects move; poses tell where they are
    const double sx = number(solid, "x_m"), sy = number(solid, "y_m"), heading = number(solid, "heading_rad"),
                 radius = number(solid, "radius_m");
    if (radius > 0) {
      out.cylinders.push_back(cylinder(sx, sy, radius, robot_height_m, obstacle));
      continue;
    }
    const auto first = solid.value("first_corner", std::int64_t{0}), count = solid.value("n_corners", std::int64_t{0});
    if (first < 0 || count < 0 || count > static_cast<std::int64_t>(corners.size()) ||
        first > static_cast<std::int64_t>(corners.size()) - count)
      continue;
    json points = json::array();
    for (std::int64_t i = first; i < first + count; ++i) {
      const json& corner = corners[static_cast<std::size_t>(i)];
      const double cx = number(corner, "x_m"), cy = number(corner, "y_m");
      points.push_back(point(sx + cx * std::cos(heading) - cy * std::sin(heading),
                             sy + cx * std::sin(heading) + cy * std::cos(heading), 0));
    }
    out.lines.push_back(line(loop, points, obstacle));
  }
  return out;
}

json object_schema(std::initializer_list<std::pair<const char*, json>> members) {
  json properties = json::object();
  for (const auto& [name, schema] : members) properties[name] = schema;
  return {{"type", "object"}, {"properties", properties}};
}

json list_of(const json& schema) {
  return {{"type", "array"}, {"items", schema}};
}

}  // namespace

std::string Scene::update(std::string_view channel, std::int64_t t_us, std::uint64_t time_ns, const Type& type,
                          std::span<const std::byte> message) {
  const std::string stamp = fmt::format("{{\"sec\":{},\"nsec\":{}}}", time_ns / 1'000'000'000, time_ns % 1'000'000'000);
  std::string frame;
  append_json_text(frame, lab_);
  const auto entity = [&](std::string_view id, std::string_view cylinders, std::string_view lines,
                          std::string_view triangles, std::string_view texts) {
    return fmt::format(
        "{{\"deletions\":[],\"entities\":[{{\"timestamp\":{},\"frame_id\":{},\"id\":\"{}\",\"lifetime\":{{\"sec\":0,"
        "\"nsec\":0}},"
        "\"frame_locked\":true,\"metadata\":[],\"arrows\":[],\"cubes\":[],\"spheres\":[],\"cylinders\":{},\"lines\":{},"
        "\"triangles\":{},\"texts\":{},\"models\":[]}}]}}",
        stamp, frame, id, cylinders, lines, triangles, texts);
  };
  if (channel == "poses") {
    // swarms above 1000 robots come in parts of one time
    if (robots_us_ >= 0 && t_us != robots_us_ && t_us < robots_us_ + robots_every_us) return {};
    robots_us_ = t_us;
    RobotDrawing robots(robot_radius_m_);
    visit(type, message, robots);
    const json headings = line(segments, json::array(), {1, 1, 1});
    std::string lines = "[" + headings.dump() + "]";
    const std::string_view no_points = "\"points\":[";
    lines.insert(lines.find(no_points) + no_points.size(), robots.headings);
    return entity(fmt::format("robots {}", robots.part), "[" + robots.cylinders + "]", lines, "[]", "[]");
  }
  if (channel != "shared" && channel != "overlay" && channel != "arena") return {};
  Parts parts;
  if (channel == "overlay") {
    hal::Drawing drawing;
    hal::Counters refused;  // nobody asks: the lab has told of its own
    if (!hal::read_overlay(message, drawing, refused)) return {};
    parts = parts_of(drawing);
  } else {
    std::string text;
    append_json(text, type, message);
    const json told = json::parse(text, nullptr, false);
    if (!told.is_object()) return {};
    if (const double radius_m = number(told, "body_radius_m"); channel == "arena" && radius_m > 0 && radius_m < 1)
      robot_radius_m_ = radius_m;
    parts = channel == "shared" ? others_of(told, lab_, robot_radius_m_) : arena_of(told);
  }
  const auto dumped = [](const json& part) { return part.dump(-1, ' ', true, json::error_handler_t::replace); };
  return entity(channel, dumped(parts.cylinders), dumped(parts.lines), dumped(parts.triangles), dumped(parts.texts));
}

// As published in Foxglove's list of schemas, without the parts of an entity that nothing here uses.
std::string scene_schema() {
  const json real = {{"type", "number"}}, whole = {{"type", "integer"}}, text = {{"type", "string"}},
             flag = {{"type", "boolean"}};
  const json time = object_schema({{"sec", whole}, {"nsec", whole}});
  const json vector = object_schema({{"x", real}, {"y", real}, {"z", real}});
  const json turn = object_schema({{"x", real}, {"y", real}, {"z", real}, {"w", real}});
  const json place_of = object_schema({{"position", vector}, {"orientation", turn}});
  const json colour = object_schema({{"r", real}, {"g", real}, {"b", real}, {"a", real}});
  const json cylinders = object_schema(
      {{"pose", place_of}, {"size", vector}, {"bottom_scale", real}, {"top_scale", real}, {"color", colour}});
  const json lines = object_schema({{"type", whole},
                                    {"pose", place_of},
                                    {"thickness", real},
                                    {"scale_invariant", flag},
                                    {"points", list_of(vector)},
                                    {"color", colour},
                                    {"colors", list_of(colour)},
                                    {"indices", list_of(whole)}});
  const json triangles = object_schema({{"pose", place_of},
                                        {"points", list_of(vector)},
                                        {"color", colour},
                                        {"colors", list_of(colour)},
                                        {"indices", list_of(whole)}});
  const json texts = object_schema({{"pose", place_of},
                                    {"billboard", flag},
                                    {"font_size", real},
                                    {"scale_invariant", flag},
                                    {"color", colour},
                                    {"text", text}});
  const json nothing = list_of(json{{"type", "object"}});
  const json entity = object_schema({{"timestamp", time},
                                     {"frame_id", text},
                                     {"id", text},
                                     {"lifetime", time},
                                     {"frame_locked", flag},
                                     {"metadata", nothing},
                                     {"arrows", nothing},
                                     {"cubes", nothing},
                                     {"spheres", nothing},
                                     {"cylinders", list_of(cylinders)},
                                     {"lines", list_of(lines)},
                                     {"triangles", list_of(triangles)},
                                     {"texts", list_of(texts)},
                                     {"models", nothing}});
  const json deletion = object_schema({{"timestamp", time}, {"type", whole}, {"id", text}});
  json schema = object_schema({{"deletions", list_of(deletion)}, {"entities", list_of(entity)}});
  schema["title"] = "foxglove.SceneUpdate";
  return schema.dump();
}

}  // namespace arkmesh::recording
