// What a scenario draws, as Foxglove's 3D scene: each shape where it is, in its colour, filled where it is filled.
#include "recording/export/scene.hpp"

#include <doctest/doctest.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arkmesh/shared_view_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/layout/types.hpp"
#include "hal/overlay/drawing_message.hpp"
#include "recording/export/scene_parts.hpp"

using namespace arkmesh;
using hal::Colour, hal::Drawing;
using nlohmann::json;

namespace {

template <class Message>
std::vector<std::byte> bytes_of(const Message& message) {
  std::vector<std::byte> out(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(out.data(), 0, static_cast<int>(out.size()));
  return out;
}

std::vector<std::byte> drawing_bytes(const Drawing& drawing) {
  return bytes_of(hal::to_message(drawing, hal::LabTime{0}));
}

json in_json(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions all;
  all.always_print_primitive_fields = all.always_print_enums_as_ints = all.preserve_proto_field_names = true;
  std::string out;
  REQUIRE(google::protobuf::util::MessageToJsonString(message, &out, all).ok());
  return json::parse(out);
}

// What is shown on a topic; null: nothing.
json shown_on(std::string_view topic, const std::vector<recording::Scene::Shown>& shown) {
  const auto found = std::ranges::find(shown, topic, &recording::Scene::Shown::topic);
  return found == shown.end() ? json() : in_json(*found->message);
}

// The one entity of a scene that holds this drawing.
template <class Shape>
json scene_of(Shape shape) {
  Drawing drawing;
  REQUIRE(drawing.add(std::move(shape)).empty());
  double next_x_m = 0;
  const json update =
      shown_on("scene", recording::Scene("shark", next_x_m)
                            .update("overlay", 0, 0, *hal::layout::types().find("overlay_t"), drawing_bytes(drawing)));
  REQUIRE(update.at("entities").size() == 1);
  return update["entities"][0];
}

// Square metres that the triangles cover, none of them twice if the sum is the shape's.
double area_m2(const json& entity) {
  double sum = 0;
  for (const json& each : entity.at("triangles")) {
    const auto at = [&](std::size_t i, const char* axis) {
      return each.at("points").at(each.at("indices").at(i).get<std::size_t>()).at(axis).get<double>();
    };
    for (std::size_t i = 0; i < each.at("indices").size(); i += 3)
      sum += std::abs((at(i + 1, "x") - at(i, "x")) * (at(i + 2, "y") - at(i, "y")) -
                      (at(i + 2, "x") - at(i, "x")) * (at(i + 1, "y") - at(i, "y"))) /
             2;
  }
  return sum;
}

double red_of(Colour colour) {
  return (hal::look_of(colour).dark >> 16) / 255.0;
}

}  // namespace

TEST_CASE("scene: circles are rings, and discs where they are filled") {
  hal::Circle circle{.at = {0.5, -0.25}, .radius_m = 0.2, .colour = Colour::site_hard, .label = "1/2"};
  json entity = scene_of(circle);
  CHECK(entity["triangles"].empty());
  REQUIRE(entity["lines"].size() == 1);
  CHECK(entity["lines"][0]["type"] == 1);
  for (const json& point : entity["lines"][0]["points"])
    CHECK(std::hypot(point["x"].get<double>() - 0.5, point["y"].get<double>() + 0.25) ==
          doctest::Approx(0.2).epsilon(1e-3));
  CHECK(entity["lines"][0]["color"]["r"].get<double>() == doctest::Approx(red_of(Colour::site_hard)).epsilon(0.01));
  REQUIRE(entity["texts"].size() == 1);
  CHECK(entity["texts"][0]["text"] == "1/2");
  circle.filled = true;
  entity = scene_of(circle);
  CHECK(area_m2(entity) == doctest::Approx(3.14159 * 0.04).epsilon(0.02));
  CHECK(entity["triangles"][0]["color"]["a"].get<double>() == doctest::Approx(hal::fill_opacity));
}

TEST_CASE("scene: polygons are filled in either direction, also those with a bay") {
  // An L of three unit squares.
  std::vector<hal::Point> corners{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (int turn = 0; turn < 2; ++turn) {
    const json entity = scene_of(hal::Polygon{.corners = corners, .colour = Colour::region_rich, .filled = true});
    CHECK(area_m2(entity) == doctest::Approx(3));
    CHECK(entity["triangles"][0]["indices"].size() == 3 * 4);
    std::reverse(corners.begin(), corners.end());
  }
  CHECK(scene_of(hal::Polygon{.corners = corners})["triangles"].empty());
}

TEST_CASE("scene: dashes are pieces of a line, ends included") {
  const json whole = scene_of(hal::Line{.points = {{-1, 0}, {1, 0}}})["lines"][0];
  CHECK(whole["type"] == 0);
  CHECK(whole["points"].size() == 2);
  const json dashed = scene_of(hal::Line{.points = {{-1, 0}, {1, 0}}, .dashed = true})["lines"][0];
  CHECK(dashed["type"] == 2);
  const json& points = dashed["points"];
  CHECK(points.front()["x"] == -1);
  CHECK(points.back()["x"] == 1);
  double drawn_m = 0;
  for (std::size_t i = 0; i < points.size(); i += 2)
    drawn_m += points[i + 1]["x"].get<double>() - points[i]["x"].get<double>();
  CHECK(drawn_m > 0.8);
  CHECK(drawn_m < 1.2);
}

TEST_CASE("scene: rasters by cells, many cells by fewer squares") {
  json entity = scene_of(hal::Raster{.corner = {0, 0, 0}, .cell_m = 0.5, .columns = 2, .cells = {255, 0, 0, 51}});
  CHECK(area_m2(entity) == doctest::Approx(0.5));
  const json& colours = entity["triangles"][0]["colors"];
  REQUIRE(colours.size() == 8);
  CHECK(colours[0]["a"].get<double>() == doctest::Approx(hal::raster_opacity));
  CHECK(colours[7]["a"].get<double>() == doctest::Approx(hal::raster_opacity / 5).epsilon(0.01));
  entity = scene_of(
      hal::Raster{.corner = {0, 0, 1}, .cell_m = 0.01, .columns = 250, .cells = std::vector<std::uint8_t>(62'500, 9)});
  CHECK(area_m2(entity) == doctest::Approx(6.25).epsilon(1e-3));
  CHECK(entity["triangles"][0]["points"].size() <= 4 * 48 * 48);
}

TEST_CASE("scene: robots are points in the colours of their LEDs, and poses now and then") {
  double next_x_m = 0;
  recording::Scene scene("shark", next_x_m);
  hal::PoseFrame frame;
  frame.robots.push_back({hal::RobotId{7}, {0.1, -0.2, 1.5}, hal::Led::red, 1, {}});
  frame.robots.push_back({hal::RobotId{900}, {0, 0.25, -3}, hal::Led::off, 1, {}});
  int poses = 0;
  for (int tenth = 0; tenth < 11; ++tenth) {
    frame.stamp = hal::LabTime{tenth * 100'000};
    const auto shown =
        scene.update("poses", frame.stamp.count(), 5'000'000'001, *hal::layout::types().find("pose_frame_t"),
                     bytes_of(hal::to_messages(frame).at(0)));
    const auto& cloud = dynamic_cast<const foxglove::PointCloud&>(*shown.at(0).message);
    CHECK(cloud.frame_id() == "shark");
    CHECK(cloud.timestamp().seconds() == 5);
    CHECK(cloud.timestamp().nanos() == 1);
    REQUIRE(cloud.data().size() == 2 * cloud.point_stride());
    const auto number = [&](const char* name, std::size_t robot, auto as) {
      for (const foxglove::PackedElementField& field : cloud.fields())
        if (field.name() == name)
          std::memcpy(&as, cloud.data().data() + robot * cloud.point_stride() + field.offset(), sizeof as);
      return as;
    };
    CHECK(number("x", 0, 0.0F) == doctest::Approx(0.1).epsilon(1e-4));
    CHECK(number("y", 1, 0.0F) == doctest::Approx(0.25).epsilon(1e-4));
    CHECK(number("heading", 0, 0.0F) == doctest::Approx(1.5).epsilon(1e-4));
    CHECK(number("robot", 1, std::uint16_t{}) == 900);
    CHECK(number("red", 0, std::uint8_t{}) > 200);
    CHECK(number("red", 1, std::uint8_t{}) < 100);
    const json told = shown_on("headings", shown);
    if (told.is_null()) continue;
    ++poses;
    REQUIRE(told["poses"].size() == 2);
    CHECK(told["poses"][0]["position"]["y"].get<double>() == doctest::Approx(-0.2).epsilon(1e-4));
    CHECK(told["poses"][0]["orientation"]["z"].get<double>() == doctest::Approx(std::sin(0.75)).epsilon(1e-3));
  }
  CHECK(poses == 3);
}

TEST_CASE("scene: robots of other labs are points of this arena, which lies in the world") {
  double next_x_m = 0;
  recording::Scene scene("shark", next_x_m);
  arkmesh::shared_view_t view{};
  view.scale = 2;
  view.shift_x_m = 0.1;
  view.n_labs = 1;
  view.labs.resize(1);
  view.labs[0].lab = "roark";
  view.labs[0].n_robots = 1;
  view.labs[0].robots.resize(1);
  view.labs[0].robots[0].x_um = 300'000;
  const hal::layout::Type& type = *hal::layout::types().find("shared_view_t");
  const auto shown = scene.update("shared", 0, 0, type, bytes_of(view));
  const auto& cloud = dynamic_cast<const foxglove::PointCloud&>(*shown.at(0).message);
  REQUIRE(cloud.data().size() == cloud.point_stride());
  float x = 0;
  std::memcpy(&x, cloud.data().data() + cloud.fields(0).offset(), sizeof x);
  CHECK(x == doctest::Approx(0.1).epsilon(1e-4));
  view.labs[0].lab = "shark";
  CHECK(dynamic_cast<const foxglove::PointCloud&>(*scene.update("shared", 0, 0, type, bytes_of(view)).at(0).message)
            .data()
            .empty());
  hal::ArenaInfo info;
  info.name = "shark";
  info.width_m = 2;
  const json frames = shown_on("frames", scene.update("arena", 0, 0, *hal::layout::types().find("arena_info_t"),
                                                      bytes_of(hal::to_message(info))));
  CHECK(frames["transforms"][0]["child_frame_id"] == "shark");
  CHECK(frames["transforms"][0]["translation"]["x"] == 1.0);
  CHECK(next_x_m > 2);
}

TEST_CASE("scene: texts where they are, and an empty drawing takes all away") {
  const json text = scene_of(hal::Text{{0.1, 0.2}, "north \"N\"", Colour::note})["texts"][0];
  CHECK(text["text"] == "north \"N\"");
  CHECK(text["pose"]["position"]["y"] == 0.2);
  double next_x_m = 0;
  recording::Scene scene("shark", next_x_m);
  const hal::layout::Type& type = *hal::layout::types().find("overlay_t");
  const json empty = shown_on("scene", scene.update("overlay", 0, 0, type, drawing_bytes({})))["entities"][0];
  for (const char* part : {"lines", "triangles", "texts"}) CHECK(empty[part].empty());
  CHECK(empty["id"] == "overlay");
  const std::vector<std::byte> whole = drawing_bytes({});
  CHECK(scene.update("overlay", 0, 0, type, std::span(whole).first(9)).empty());
}
