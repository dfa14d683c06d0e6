#include "recording/export/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "hal/overlay/drawing_message.hpp"
#include "recording/export/drawn_scene.hpp"
#include "recording/export/json.hpp"
#include "recording/export/proto.hpp"

namespace arkmesh::recording {
namespace {

using namespace hal::layout;

using nlohmann::json;
using namespace scene;

constexpr std::int64_t poses_every_us = 500'000;

constexpr Colour led_colours[9] = {{0.2, 0.2, 0.2}, {0.88, 0.19, 0.13}, {0.13, 0.63, 0.13},
                                   {0.82, 0.63, 0}, {0.19, 0.31, 0.88}, {0.88, 0.13, 0.88},
                                   {0, 0.69, 0.69}, {1, 1, 1},          {0.5, 0.5, 0.5}};
constexpr Colour wall{0.3, 0.3, 0.3}, obstacle{0.5, 0.45, 0.4};

// A number of a message, 0 when it is not there or no place to draw at.
double number(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? place(found->get<double>()) : 0;
}

json in_json(const Type& type, std::span<const std::byte> message) {
  std::string text;
  append_json(text, type, message);
  return json::parse(text, nullptr, false);
}

const json& list(const json& object, const char* key) {
  static const json none = json::array();
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : none;
}

// Numbers that differ little from frame to frame, with few bits that do, take less when they are compressed.
double rounded(double value, double step) {
  return std::abs(value) <= max_place_m ? std::round(value / step) * step : 0;
}
constexpr double place_step = 1.0 / (1 << 17), heading_step = 1.0 / (1 << 13), turn_step = 1.0 / (1 << 14);

struct Robot {
  float x = 0, y = 0, z = 0, heading = 0;
  std::uint16_t id = 0;
  std::uint8_t led = 8, red = 0, green = 0, blue = 0, alpha = 255, unused = 0;
};
struct RobotField {
  const char* name;
  std::size_t offset;
  foxglove::PackedElementField::NumericType type;
};
using foxglove::PackedElementField;
constexpr RobotField robot_fields[] = {{"x", offsetof(Robot, x), PackedElementField::FLOAT32},
                                       {"y", offsetof(Robot, y), PackedElementField::FLOAT32},
                                       {"z", offsetof(Robot, z), PackedElementField::FLOAT32},
                                       {"heading", offsetof(Robot, heading), PackedElementField::FLOAT32},
                                       {"robot", offsetof(Robot, id), PackedElementField::UINT16},
                                       {"led", offsetof(Robot, led), PackedElementField::UINT8},
                                       {"red", offsetof(Robot, red), PackedElementField::UINT8},
                                       {"green", offsetof(Robot, green), PackedElementField::UINT8},
                                       {"blue", offsetof(Robot, blue), PackedElementField::UINT8},
                                       {"alpha", offsetof(Robot, alpha), PackedElementField::UINT8}};

Robot coloured(Robot robot) {
  const Colour& c = led_colours[robot.led];
  const auto part = [](double of_one) { return static_cast<std::uint8_t>(std::lround(255 * of_one)); };
  robot.red = part(c.r), robot.green = part(c.g), robot.blue = part(c.b);
  return robot;
}

class Robots : public Visitor {
 public:
  void value(const Field& field, const Value& value) override {
    if (!in_robot_) return;
    if (field.name == "robot") now_.id = static_cast<std::uint16_t>(value.integer);
    if (field.name == "x_m") now_.x = static_cast<float>(rounded(value.real, place_step));
    if (field.name == "y_m") now_.y = static_cast<float>(rounded(value.real, place_step));
    if (field.name == "heading_rad") now_.heading = static_cast<float>(rounded(value.real, heading_step));
    if (field.name == "led") now_.led = static_cast<std::uint8_t>(std::min<std::int64_t>(value.integer & 255, 8));
  }
  void bytes(const Field&, std::span<const std::byte>) override {}
  void begin_list(const Field& field, std::size_t) override { in_robot_ = field.name == "robots"; }
  void end_list(const Field&) override { in_robot_ = false; }
  void begin_record(const Field&, std::size_t) override { now_ = {}; }
  void end_record(const Field&) override {
    if (!in_robot_) return;
    all.push_back(coloured(now_));
  }

  std::vector<Robot> all;

 private:
  Robot now_;
  bool in_robot_ = false;
};

template <class To>
void stamp(To& to, std::uint64_t time_ns, const std::string& frame) {
  to.mutable_timestamp()->set_seconds(static_cast<std::int64_t>(time_ns / 1'000'000'000));
  to.mutable_timestamp()->set_nanos(static_cast<std::int32_t>(time_ns % 1'000'000'000));
  to.set_frame_id(frame);
}

void draw_arena(foxglove::SceneEntity& to, const json& arena) {
  const double x = number(arena, "width_m") / 2, y = number(arena, "height_m") / 2;
  add_line(to, foxglove::LinePrimitive::LINE_LOOP, std::vector<Point>{{-x, -y}, {x, -y}, {x, y}, {-x, y}}, wall);
  const json& corners = list(arena, "corners");
  for (const json& solid : list(arena, "solids")) {
    if (number(solid, "mass_kg") > 0) continue;  // objects move; poses tell where they are
    const double sx = number(solid, "x_m"), sy = number(solid, "y_m"), heading = number(solid, "heading_rad"),
                 radius = number(solid, "radius_m");
    if (radius > 0) {
      add_cylinder(to, sx, sy, radius, drawn_height_m, obstacle);
      continue;
    }
    const auto first = solid.value("first_corner", std::int64_t{0}), count = solid.value("n_corners", std::int64_t{0});
    if (first < 0 || count < 0 || count > static_cast<std::int64_t>(corners.size()) ||
        first > static_cast<std::int64_t>(corners.size()) - count)
      continue;
    std::vector<Point> points;
    for (std::int64_t i = first; i < first + count; ++i) {
      const json& corner = corners[static_cast<std::size_t>(i)];
      const double cx = number(corner, "x_m"), cy = number(corner, "y_m");
      points.push_back(
          {sx + cx * std::cos(heading) - cy * std::sin(heading), sy + cx * std::sin(heading) + cy * std::cos(heading)});
    }
    add_line(to, foxglove::LinePrimitive::LINE_LOOP, points, obstacle);
  }
}

// Robots of other labs, from the shared frame to this arena's.
std::vector<Robot> others_of(const json& view, const std::string& own) {
  std::vector<Robot> out;
  const double scale = number(view, "scale"), turn = number(view, "turn_rad");
  if (scale <= 0) return out;
  for (const json& lab : list(view, "labs")) {
    if (lab.value("lab", "") == own) continue;
    for (const json& robot : list(lab, "robots")) {
      const double x = robot.value("x_um", 0) / 1e6 - number(view, "shift_x_m"),
                   y = robot.value("y_um", 0) / 1e6 - number(view, "shift_y_m");
      const double c = std::cos(turn), s = std::sin(turn);
      out.push_back(
          coloured({.x = static_cast<float>(rounded((c * x + s * y) / scale, place_step)),
                    .y = static_cast<float>(rounded((c * y - s * x) / scale, place_step)),
                    .heading = static_cast<float>(rounded(robot.value("heading_urad", 0) / 1e6 - turn, heading_step)),
                    .id = static_cast<std::uint16_t>(robot.value("robot", 0)),
                    .led = static_cast<std::uint8_t>(std::clamp(robot.value("led", 0), 0, 8)),
                    .alpha = 153}));
    }
  }
  return out;
}

std::unique_ptr<foxglove::PointCloud> cloud_of(const std::vector<Robot>& robots, std::uint64_t time_ns,
                                               const std::string& frame) {
  auto cloud = std::make_unique<foxglove::PointCloud>();
  stamp(*cloud, time_ns, frame);
  set_pose(*cloud->mutable_pose(), {});
  cloud->set_point_stride(sizeof(Robot));
  for (const RobotField& field : robot_fields) {
    PackedElementField& one = *cloud->add_fields();
    one.set_name(field.name);
    one.set_offset(static_cast<std::uint32_t>(field.offset));
    one.set_type(field.type);
  }
  cloud->set_data(reinterpret_cast<const char*>(robots.data()), robots.size() * sizeof(Robot));
  return cloud;
}

}  // namespace

std::vector<Scene::Shown> Scene::update(std::string_view channel, std::int64_t t_us, std::uint64_t time_ns,
                                        const Type& type, std::span<const std::byte> message) {
  std::vector<Shown> out;
  if (channel == "poses") show_robots(out, t_us, time_ns, type, message);
  if (channel == "shared")
    out.push_back({"others", cloud_of(others_of(in_json(type, message), lab_), time_ns, utf8(lab_))});
  if (channel != "overlay" && channel != "arena") return out;
  auto update = std::make_unique<foxglove::SceneUpdate>();
  foxglove::SceneEntity& entity = *update->add_entities();
  stamp(entity, time_ns, utf8(lab_));
  entity.set_id(std::string(channel));
  entity.set_frame_locked(true);
  if (!draw(entity, channel, type, message)) return out;
  out.push_back({"scene", std::move(update)});
  if (channel != "arena" || std::exchange(placed_, true)) return out;
  const double width_m = 2 * std::abs(entity.lines(0).points(0).x());
  auto frames = std::make_unique<foxglove::FrameTransforms>();
  foxglove::FrameTransform& one = *frames->add_transforms();
  one.mutable_timestamp()->CopyFrom(entity.timestamp());
  one.set_parent_frame_id("world");
  one.set_child_frame_id(entity.frame_id());
  one.mutable_translation()->set_x(next_x_m_ + width_m / 2);
  one.mutable_rotation()->set_w(1);
  next_x_m_ += 1.1 * width_m;
  out.push_back({"frames", std::move(frames)});
  return out;
}

void Scene::show_robots(std::vector<Shown>& out, std::int64_t t_us, std::uint64_t time_ns, const Type& type,
                        std::span<const std::byte> message) {
  Robots robots;
  visit(type, message, robots);
  out.push_back({"robots", cloud_of(robots.all, time_ns, utf8(lab_))});
  // swarms above 1000 robots come in parts of one time
  if (poses_us_ >= 0 && t_us != poses_us_ && t_us < poses_us_ + poses_every_us) return;
  poses_us_ = t_us;
  auto poses = std::make_unique<foxglove::PosesInFrame>();
  stamp(*poses, time_ns, utf8(lab_));
  for (const Robot& robot : robots.all) {
    foxglove::Pose& pose = *poses->add_poses();
    set_pose(pose, {robot.x, robot.y, body_height_m_}, robot.heading);
    pose.mutable_orientation()->set_z(rounded(pose.orientation().z(), turn_step));
    pose.mutable_orientation()->set_w(rounded(pose.orientation().w(), turn_step));
  }
  out.push_back({"headings", std::move(poses)});
}

bool Scene::draw(foxglove::SceneEntity& to, std::string_view channel, const Type& type,
                 std::span<const std::byte> message) {
  if (channel == "overlay") {
    hal::Drawing drawing;
    hal::Counters refused;  // nobody asks: the lab has told of its own
    if (!hal::read_overlay(message, drawing, refused)) return false;
    scene::draw(to, drawing);
    return true;
  }
  const json told = in_json(type, message);
  if (!told.is_object()) return false;
  draw_arena(to, told);
  body_height_m_ = number(told, "body_height_m");
  return true;
}

}  // namespace arkmesh::recording
