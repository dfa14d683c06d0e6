// What a scenario draws, over a camera's picture, by its pixels.
#include "tracker/overlay_painter.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

using namespace arkmesh;
using namespace arkmesh::hal;

namespace {

// A metre of arena on 800 x 800 pixels, seen from above; the arena is dark grey.
struct PaintedArena {
  cv::Mat picture = cv::Mat(800, 800, CV_8UC3, cv::Scalar::all(40));
  tracker::Calibration camera = tracker::Calibration::overhead(800, 800, 1.0 / 800);
  Drawing drawing;

  template <class Shape>
  PaintedArena& with(Shape shape) {
    REQUIRE(drawing.add(std::move(shape)).empty());
    return *this;
  }
  cv::Mat drawn() const {
    cv::Mat out = picture.clone();
    tracker::draw_overlay(out, camera, drawing);
    return out;
  }
};

cv::Vec3b arena_pixel(const cv::Mat& picture, double x_m, double y_m) {
  return picture.at<cv::Vec3b>(static_cast<int>(399.5 - 800 * y_m), static_cast<int>(399.5 + 800 * x_m));
}

cv::Vec3b ink(Colour colour) {
  const std::uint32_t rgb = look_of(colour).dark;
  return {static_cast<unsigned char>(rgb), static_cast<unsigned char>(rgb >> 8), static_cast<unsigned char>(rgb >> 16)};
}

// The arena's grey under a colour of that opacity.
cv::Vec3b under(Colour colour, double opacity) {
  cv::Vec3b out;
  for (int i = 0; i < 3; ++i) out[i] = static_cast<unsigned char>(40 * (1 - opacity) + ink(colour)[i] * opacity);
  return out;
}

bool alike(const cv::Vec3b& a, const cv::Vec3b& b, int by = 12) {
  return cv::norm(cv::Vec3i(a) - cv::Vec3i(b), cv::NORM_INF) <= by;
}

const cv::Vec3b bare(40, 40, 40);

// Pixels in a window around a place that are alike to one colour.
int inked(const cv::Mat& picture, double x_m, double y_m, double half_m, const cv::Vec3b& colour) {
  int n = 0;
  for (double x = x_m - half_m; x <= x_m + half_m; x += 1.0 / 800)
    for (double y = y_m - half_m; y <= y_m + half_m; y += 1.0 / 800) n += alike(arena_pixel(picture, x, y), colour, 40);
  return n;
}

}  // namespace

TEST_CASE("overlay: a circle's outline and its fill") {
  // The outline is on the circle; inside there is the fill or nothing; outside nothing.
  PaintedArena arena;
  arena.with(Circle{.at = {-0.2, 0.1}, .radius_m = 0.1, .colour = Colour::site_active});
  arena.with(Circle{.at = {0.2, 0.1}, .radius_m = 0.1, .colour = Colour::site_active, .filled = true});
  const cv::Mat drawn = arena.drawn();
  for (double x_m : {-0.2, 0.2}) {
    CHECK(inked(drawn, x_m + 0.1, 0.1, 0.005, ink(Colour::site_active)) > 0);
    CHECK(inked(drawn, x_m, 0.2, 0.005, ink(Colour::site_active)) > 0);
    CHECK(alike(arena_pixel(drawn, x_m, 0.22), bare));
  }
  CHECK(alike(arena_pixel(drawn, -0.2, 0.1), bare));
  CHECK(alike(arena_pixel(drawn, 0.2, 0.1), under(Colour::site_active, fill_opacity)));
}

TEST_CASE("overlay: a polygon's outline and its fill") {
  PaintedArena arena;
  arena.with(Polygon{.corners = {{-0.3, -0.1}, {0.3, -0.1}, {0, 0.3}}, .colour = Colour::region_poor, .filled = true});
  const cv::Mat drawn = arena.drawn();
  CHECK(alike(arena_pixel(drawn, 0, 0), under(Colour::region_poor, fill_opacity)));
  CHECK(inked(drawn, 0, -0.1, 0.005, ink(Colour::region_poor)) > 0);
  CHECK(inked(drawn, 0.15, 0.1, 0.005, ink(Colour::region_poor)) > 0);
  CHECK(alike(arena_pixel(drawn, 0.25, 0.2), bare));
  CHECK(alike(arena_pixel(drawn, 0, -0.2), bare));
}

TEST_CASE("overlay: patterns lie over fills, each its own") {
  // Stripes rise to the right: along them nothing changes, across them it does. A cross has stripes both ways.
  const auto changes = [](Colour colour, int dx, int dy) {
    PaintedArena arena;
    arena.with(Circle{.at = {0, 0}, .radius_m = 0.3, .colour = colour, .filled = true});
    const cv::Mat drawn = arena.drawn();
    int most = 0;
    for (int start = 0; start < 12; ++start) {
      int n = 0;
      for (int i = -30; i < 30; ++i)
        n += drawn.at<cv::Vec3b>(400 + dy * i, 400 + start + dx * i) !=
             drawn.at<cv::Vec3b>(400 + dy * (i + 1), 400 + start + dx * (i + 1));
      most = std::max(most, n);
    }
    return most;
  };
  CHECK(changes(Colour::site_active, 1, 0) == 0);
  CHECK(changes(Colour::site_active, 0, 1) == 0);
  CHECK(changes(Colour::site_hard, 1, 0) > 10);
  CHECK(changes(Colour::site_hard, 1, -1) == 0);
  CHECK(changes(Colour::warning, 1, -1) > 10);
  CHECK(changes(Colour::warning, 1, 1) > 10);
  CHECK(changes(Colour::region_rich, 1, 0) > 10);
}

TEST_CASE("overlay: dashed outlines have gaps, others have none") {
  for (bool dashed : {false, true}) {
    PaintedArena arena;
    arena.with(Line{.points = {{-0.4, 0}, {0.4, 0}}, .colour = Colour::note, .dashed = dashed});
    arena.with(Circle{.at = {0, 0}, .radius_m = 0.3, .colour = Colour::own, .dashed = dashed});
    const cv::Mat drawn = arena.drawn();
    int on = 0, all = 0, around = 0;
    for (double x_m = -0.25; x_m < 0.25; x_m += 1.0 / 800, ++all)
      on += inked(drawn, x_m, 0, 0.0013, ink(Colour::note)) > 0;
    for (int degrees = 0; degrees < 360; ++degrees)
      around += inked(drawn, 0.3 * std::cos(degrees / 57.29578), 0.3 * std::sin(degrees / 57.29578), 0.0013,
                      ink(Colour::own)) > 0;
    CAPTURE(dashed);
    CHECK((dashed ? on > 0.4 * all && on < 0.9 * all : on == all));
    CHECK((dashed ? around > 100 && around < 330 : around == 360));
  }
}

TEST_CASE("overlay: a line goes through its points") {
  PaintedArena arena;
  arena.with(Line{.points = {{-0.3, -0.3}, {0, 0.2}, {0.3, -0.3}}, .colour = Colour::other});
  const cv::Mat drawn = arena.drawn();
  for (const auto& [x_m, y_m] : {std::pair{-0.3, -0.3}, {-0.15, -0.05}, {0.0, 0.2}, {0.15, -0.05}})
    CHECK(inked(drawn, x_m, y_m, 0.006, ink(Colour::other)) > 0);
  CHECK(alike(arena_pixel(drawn, 0, -0.3), bare));  // open: the last point is not joined with the first
}

TEST_CASE("overlay: a raster's cells by their values, where it is turned to") {
  // Two columns, two rows, corner in the middle of the arena; turned by 90 degrees the rows go north and columns west.
  for (bool turned : {false, true}) {
    PaintedArena arena;
    arena.with(Raster{.corner = {0, 0, turned ? 1.5707963267948966 : 0},
                      .cell_m = 0.1,
                      .columns = 2,
                      .cells = {255, 100, 0, 255},
                      .colour = Colour::pheromone});
    const cv::Mat drawn = arena.drawn();
    const double side = turned ? -1 : 1;
    CHECK(alike(arena_pixel(drawn, side * 0.05, 0.05), under(Colour::pheromone, raster_opacity)));
    CHECK(alike(arena_pixel(drawn, side * (turned ? 0.05 : 0.15), turned ? 0.15 : 0.05),
                under(Colour::pheromone, raster_opacity * 100 / 255)));
    CHECK(alike(arena_pixel(drawn, side * (turned ? 0.15 : 0.05), turned ? 0.05 : 0.15), bare));
    CHECK(alike(arena_pixel(drawn, side * 0.15, 0.15), under(Colour::pheromone, raster_opacity)));
    CHECK(alike(arena_pixel(drawn, -side * 0.05, 0.05), bare));
    CHECK(alike(arena_pixel(drawn, side * 0.25, 0.05), bare));
  }
}

TEST_CASE("overlay: words stand where they belong, in their colour") {
  // A text's middle is at its place; labels are above a circle and a raster, within a polygon, at a line's middle.
  const auto words = [](auto shape, double x_m, double y_m) {
    PaintedArena arena;
    arena.with(std::move(shape));
    return inked(arena.drawn(), x_m, y_m, 0.03, ink(Colour::note));
  };
  const std::string name = "HIM";
  const Circle circle{.at = {0, 0}, .radius_m = 0.1, .colour = Colour::note};
  Circle named = circle;
  named.label = name;
  CHECK(words(circle, 0, 0.14) == 0);
  CHECK(words(named, 0, 0.12) > 10);
  CHECK(words(Text{{0.2, -0.2}, name, Colour::note}, 0.2, -0.2) > 10);
  const std::vector<Point> square{{-0.2, -0.2}, {0.2, -0.2}, {0.2, 0.2}, {-0.2, 0.2}};
  CHECK(words(Polygon{.corners = square, .colour = Colour::note}, 0, 0) == 0);
  CHECK(words(Polygon{.corners = square, .colour = Colour::note, .label = name}, 0, 0) > 10);
  CHECK(words(Line{.points = {{-0.3, 0.3}, {0, -0.1}, {0.3, 0.3}}, .colour = Colour::note, .label = name}, 0, -0.1) >
        words(Line{.points = {{-0.3, 0.3}, {0, -0.1}, {0.3, 0.3}}, .colour = Colour::note}, 0, -0.1) + 10);
  Raster raster{.corner = {-0.1, -0.1, 0}, .cell_m = 0.1, .columns = 2, .cells = {0, 0, 0, 0}, .colour = Colour::note};
  CHECK(words(raster, 0, 0.13) == 0);
  raster.label = name;
  CHECK(words(raster, 0, 0.12) > 10);
}

TEST_CASE("overlay: shapes that leave the picture, or are larger than the world, are drawn as far as they are seen") {
  PaintedArena arena;
  arena.with(Circle{.at = {0, 0}, .radius_m = 1e4, .colour = Colour::own, .filled = true, .label = "all"});
  arena.with(Polygon{.corners = {{-9, 0}, {9, 0}, {9, 9}, {-9, 9}}, .colour = Colour::region_poor, .filled = true});
  arena.with(Line{.points = {{-1e4, -0.2}, {1e4, -0.2}}, .colour = Colour::note, .dashed = true});
  arena.with(
      Raster{.corner = {-1e4, -1e4, 0}, .cell_m = 1, .columns = 256, .cells = std::vector<std::uint8_t>(65'536, 9)});
  arena.with(Text{{1e4, 1e4}, "far away"});
  const cv::Mat drawn = arena.drawn();
  CHECK_FALSE(alike(arena_pixel(drawn, 0, 0.25), arena_pixel(drawn, 0, -0.4)));
}
