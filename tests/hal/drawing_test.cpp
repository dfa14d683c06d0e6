// What scenarios draw: what a drawing takes, and its way over the bus.
#include "hal/overlay/drawing.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "hal/overlay/drawing_message.hpp"

using namespace arkmesh;
using namespace arkmesh::hal;

namespace {

constexpr double no_number_m = std::numeric_limits<double>::quiet_NaN(),
                 endless_m = std::numeric_limits<double>::infinity();

// One shape of each kind, with no field as it is by default.
Drawing one_of_each() {
  Drawing drawing;
  CHECK(drawing.add(Raster{{-0.5, -0.25, 1.5}, 0.01, 3, {0, 1, 2, 253, 254, 255}, Colour::own, "trace"}).empty());
  CHECK(drawing.add(Polygon{{{0, 0}, {1, 0}, {0.5, 2}}, Colour::region_rich, true, true, "north"}).empty());
  CHECK(drawing.add(Circle{{0.1, -0.2}, 0.05, Colour::site_hard, true, true, "2/3 \xc3\xa9"}).empty());
  CHECK(drawing.add(Line{{{-1, 0}, {0, 0.5}, {1, 0}}, Colour::warning, true, "border"}).empty());
  CHECK(drawing.add(Text{{0.3, 0.4}, "here", Colour::other}).empty());
  return drawing;
}

std::vector<std::byte> overlay_bytes(const overlay_t& message) {
  std::vector<std::byte> out(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(out.data(), 0, static_cast<int>(out.size()));
  return out;
}

overlay_circle_t overlay_circle(double x_m, double radius_m, const std::string& colour, const std::string& label = "") {
  overlay_circle_t out{};
  out.x_m = x_m, out.radius_m = radius_m, out.colour = colour, out.label = label;
  return out;
}

}  // namespace

TEST_CASE("a drawing comes over the bus as it was") {
  // Every field of every kind of shape.
  const overlay_t message = to_message(one_of_each(), LabTime{7});
  CHECK(message.stamp_us == 7);
  CHECK(message.circles[0].colour == "site_hard");
  Drawing back;
  Counters refused;
  REQUIRE(read_overlay(overlay_bytes(message), back, refused));
  CHECK(refused.all().empty());
  REQUIRE(back.size() == 5);
  const Raster& raster = back.rasters()[0];
  CHECK(raster.corner.x_m == -0.5);
  CHECK(raster.corner.y_m == -0.25);
  CHECK(raster.corner.heading_rad == 1.5);
  CHECK(raster.cell_m == 0.01);
  CHECK(raster.columns == 3);
  CHECK(raster.cells == std::vector<std::uint8_t>{0, 1, 2, 253, 254, 255});
  CHECK(raster.colour == Colour::own);
  CHECK(raster.label == "trace");
  const Polygon& polygon = back.polygons()[0];
  REQUIRE(polygon.corners.size() == 3);
  CHECK(polygon.corners[2].x_m == 0.5);
  CHECK(polygon.corners[2].y_m == 2);
  CHECK(polygon.colour == Colour::region_rich);
  CHECK(polygon.filled);
  CHECK(polygon.dashed);
  CHECK(polygon.label == "north");
  const Circle& disc = back.circles()[0];
  CHECK(disc.at.x_m == 0.1);
  CHECK(disc.at.y_m == -0.2);
  CHECK(disc.radius_m == 0.05);
  CHECK(disc.colour == Colour::site_hard);
  CHECK(disc.filled);
  CHECK(disc.dashed);
  CHECK(disc.label == "2/3 \xc3\xa9");
  const Line& line = back.lines()[0];
  REQUIRE(line.points.size() == 3);
  CHECK(line.points[1].y_m == 0.5);
  CHECK(line.colour == Colour::warning);
  CHECK(line.dashed);
  CHECK(line.label == "border");
  const Text& text = back.texts()[0];
  CHECK(text.at.x_m == 0.3);
  CHECK(text.at.y_m == 0.4);
  CHECK(text.text == "here");
  CHECK(text.colour == Colour::other);
}

TEST_CASE("a newer message replaces what was shown, and an empty one takes it away") {
  Drawing shown = one_of_each();
  Counters refused;
  CHECK(read_overlay(overlay_bytes(to_message(Drawing(), LabTime{1})), shown, refused));
  CHECK(shown.empty());
}

TEST_CASE("a shape that cannot be drawn is left out, with the reason") {
  Drawing drawing;
  CHECK(drawing.add(Circle{{no_number_m, 0}, 1}) == "number");
  CHECK(drawing.add(Circle{{0, -endless_m}, 1}) == "number");
  CHECK(drawing.add(Circle{{0, 10'001}, 1}) == "number");
  for (double radius_m : {0.0, -1.0, no_number_m, endless_m, 10'001.0})
    CHECK_MESSAGE(drawing.add(Circle{{0, 0}, radius_m}) == "number", radius_m);
  CHECK(drawing.add(Polygon{{{0, 0}, {1, 0}}}) == "points");
  CHECK(drawing.add(Polygon{{{0, 0}, {1, 0}, {no_number_m, 1}}}) == "number");
  CHECK(drawing.add(Line{{{0, 0}}}) == "points");
  CHECK(drawing.add(Line{{{0, 0}, {endless_m, 0}}}) == "number");
  CHECK(drawing.add(Text{{0, no_number_m}, "x"}) == "number");
  CHECK(drawing.add(Raster{{0, 0, no_number_m}, 0.1, 1, {1}}) == "number");
  CHECK(drawing.add(Raster{{0, 0, 0}, 0, 1, {1}}) == "number");
  CHECK(drawing.add(Raster{{0, 0, 0}, 0.1, 0, {1}}) == "cells");
  CHECK(drawing.add(Raster{{0, 0, 0}, 0.1, 2, {1, 2, 3}}) == "cells");
  CHECK(drawing.add(Raster{{0, 0, 0}, 0.1, 2, {}}) == "cells");
  CHECK(drawing.add(Text{{0, 0}, std::string(121, 'x')}) == "label");
  CHECK(drawing.add(Text{{0, 0}, "two\nlines"}) == "label");
  CHECK(drawing.add(Circle{.at = {0, 0}, .radius_m = 1, .label = std::string(1, '\0')}) == "label");
  CHECK(drawing.empty());
  CHECK(drawing.add(Text{{0, 0}, std::string(120, 'x')}).empty());
}

TEST_CASE("a drawing holds so many shapes, points and cells and no more") {
  // What did not fit takes no room from what comes after it.
  Drawing drawing;
  for (std::size_t i = 0; i < 4096; ++i) CHECK(drawing.add(Circle{{0, 0}, 1}).empty());
  CHECK(drawing.add(Circle{{0, 0}, 1}) == "too_many");
  drawing.clear();
  CHECK(drawing.add(Line{std::vector<Point>(16'000)}).empty());
  CHECK(drawing.add(Polygon{std::vector<Point>(385)}) == "too_many");
  CHECK(drawing.add(Polygon{std::vector<Point>(384)}).empty());
  CHECK(drawing.add(Circle{{0, 0}, 1}) == "too_many");
  drawing.clear();
  CHECK(drawing.add(Raster{{}, 0.1, 256, std::vector<std::uint8_t>(65'536 - 256)}).empty());
  CHECK(drawing.add(Raster{{}, 0.1, 257, std::vector<std::uint8_t>(257)}) == "too_many");
  CHECK(drawing.add(Raster{{}, 0.1, 256, std::vector<std::uint8_t>(256)}).empty());
}

TEST_CASE("an overlay from outside: what is wrong in it is left out and counted") {
  overlay_t message;
  message.circles = {overlay_circle(0, 1, "site_idle"), overlay_circle(no_number_m, 1, "own"),
                     overlay_circle(1, -1, "own"), overlay_circle(2, 1, "of_the_future"),
                     overlay_circle(3, 1, "own", std::string(200, 'x'))};
  message.n_circles = 5;
  overlay_raster_t& raster = message.rasters.emplace_back();
  raster = {};
  raster.cell_m = 0.1, raster.columns = 65'536, raster.rows = 65'537, raster.n_cells = 65'536;
  raster.cells.resize(65'536);
  message.n_rasters = 1;
  message.n_polygons = message.n_lines = message.n_texts = 0;
  Drawing drawing;
  Counters refused;
  REQUIRE(read_overlay(overlay_bytes(message), drawing, refused));
  REQUIRE(drawing.size() == 2);
  CHECK(drawing.circles()[0].colour == Colour::site_idle);
  CHECK(drawing.circles()[1].colour == Colour::note);
  CHECK(refused["overlay.refused.number"] == 2);
  CHECK(refused["overlay.refused.label"] == 1);
  CHECK(refused["overlay.refused.cells"] == 1);
}

TEST_CASE("an overlay that is no whole message changes nothing") {
  // Cut anywhere, with bytes behind it, of another type, and with counts that are forged at every place.
  const std::vector<std::byte> whole = overlay_bytes(to_message(one_of_each(), LabTime{7}));
  Drawing drawing = one_of_each();
  Counters refused;
  for (std::size_t size = 0; size < whole.size(); ++size)
    CHECK_FALSE(read_overlay(std::span(whole).first(size), drawing, refused));
  std::vector<std::byte> changed = whole;
  changed.push_back({});
  CHECK_FALSE(read_overlay(changed, drawing, refused));
  CHECK(refused["overlay.refused.trailing"] == 1);
  changed = whole;
  changed[0] ^= std::byte{1};
  CHECK_FALSE(read_overlay(changed, drawing, refused));
  CHECK(refused["overlay.refused.fingerprint"] >= 1);
  CHECK(drawing.size() == 5);
  for (const std::byte forged : {std::byte{0x7f}, std::byte{0xff}})
    for (std::size_t at = 8; at + 4 <= whole.size(); ++at) {
      changed = whole;
      std::fill_n(changed.begin() + static_cast<std::ptrdiff_t>(at), 4, forged);
      Drawing other;
      read_overlay(changed, other, refused);
      CHECK(other.size() <= 5);
    }
}

TEST_CASE("the table of colours") {
  // Names are found again, every look is another, and a foreign name is a note.
  std::set<std::uint32_t> light, dark;
  for (const ColourLook& look : colour_looks) {
    CHECK(colour_named(look.name) == look.colour);
    CHECK(look_of(look.colour).name == look.name);
    light.insert(look.light);
    dark.insert(look.dark);
  }
  CHECK(light.size() == std::size(colour_looks));
  CHECK(dark.size() == std::size(colour_looks));
  CHECK(colour_named("") == Colour::note);
  CHECK(look_of(Colour::site_hard).pattern != look_of(Colour::site_active).pattern);
  CHECK(fill_opacity > 0);
  CHECK(fill_opacity < 1);
}
