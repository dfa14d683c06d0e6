// What a scenario draws, as Foxglove's 3D scene: each shape where it is, in its colour, filled where it is filled.
#include "recording/export/scene.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "hal/arenas/messages.hpp"
#include "hal/layout/types.hpp"
#include "hal/overlay/drawing_message.hpp"

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

// The one entity of a scene that holds this drawing.
template <class Shape>
json scene_of(Shape shape) {
  Drawing drawing;
  REQUIRE(drawing.add(std::move(shape)).empty());
  const json update = json::parse(recording::Scene("shark").update(
      "overlay", 0, 0, *hal::layout::types().find("overlay_t"), drawing_bytes(drawing)));
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

TEST_CASE("scene: robots are as large as the arena told, and Kilobots before it did") {
  recording::Scene scene("shark");
  const auto width_m = [&](hal::LabTime stamp) {
    hal::PoseFrame frame;
    frame.stamp = stamp;
    frame.robots.push_back({hal::RobotId{1}, {0.1, 0.2, 0}, hal::Led::off, 1, {}});
    const std::string update = scene.update("poses", stamp.count(), 0, *hal::layout::types().find("pose_frame_t"),
                                            bytes_of(hal::to_messages(frame).at(0)));
    return json::parse(update).at("entities").at(0).at("cylinders").at(0).at("size").at("x").get<double>();
  };
  CHECK(width_m(hal::LabTime{0}) == doctest::Approx(0.033));
  hal::ArenaInfo info;
  info.name = "shark";
  info.body_radius_m = 0.02;
  scene.update("arena", 0, 0, *hal::layout::types().find("arena_info_t"), bytes_of(hal::to_message(info)));
  CHECK(width_m(hal::LabTime{10'000'000}) == doctest::Approx(0.04));
}

TEST_CASE("scene: texts where they are, and an empty drawing takes all away") {
  const json text = scene_of(hal::Text{{0.1, 0.2}, "north \"N\"", Colour::note})["texts"][0];
  CHECK(text["text"] == "north \"N\"");
  CHECK(text["pose"]["position"]["y"] == 0.2);
  recording::Scene scene("shark");
  const hal::layout::Type& type = *hal::layout::types().find("overlay_t");
  const json empty = json::parse(scene.update("overlay", 0, 0, type, drawing_bytes({})))["entities"][0];
  for (const char* part : {"lines", "triangles", "texts"}) CHECK(empty[part].empty());
  CHECK(empty["id"] == "overlay");
  const std::vector<std::byte> whole = drawing_bytes({});
  CHECK(scene.update("overlay", 0, 0, type, std::span(whole).first(9)).empty());
}
