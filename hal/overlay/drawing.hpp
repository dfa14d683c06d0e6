// What a scenario shows people in its arena: a few shapes, each with a meaning. Page, camera overlay, pictures and
// films draw them from this one description. Places are in the arena frame, metres; robots see nothing of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/overlay/colour.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

// In each: `dashed` says that it is there, but not in force; `label` is a few characters beside it.

struct Circle {
  Point at;
  double radius_m = 0;
  Colour colour = Colour::note;
  bool filled = false, dashed = false;
  std::string label;
};

struct Polygon {
  std::vector<Point> corners;  // at least 3; its sides do not cross
  Colour colour = Colour::note;
  bool filled = false, dashed = false;
  std::string label;
};

struct Line {
  std::vector<Point> points;  // at least 2
  Colour colour = Colour::note;
  bool dashed = false;
  std::string label;
};

struct Text {
  Point at;  // the words' middle
  std::string text;
  Colour colour = Colour::note;
};

// A quantity on a grid of square cells.
struct Raster {
  Pose corner;                      // of the first cell; rows go along its heading, one after the other to its left
  double cell_m = 0;                // side of a cell
  int columns = 0;                  // cells in a row
  std::vector<std::uint8_t> cells;  // row by row: 0 is not drawn, 255 is the fullest
  Colour colour = Colour::pheromone;
  std::string label;
};

// The shapes of one moment, bounded. Rasters lie lowest, then polygons, circles, lines and texts; of each kind, later
// ones lie over earlier ones.
class Drawing {
 public:
  static constexpr std::size_t max_shapes = 4096, max_points = 16'384, max_cells = 65'536, max_label = 120;  // bytes
  static constexpr double far_m = 1e4;  // nothing is farther from the arena's centre or larger
  // Whether it is short enough, and of printable characters, in UTF-8.
  static bool is_label(std::string_view text);

  // Each returns an empty text, or why the shape was left out, in one word fit for a counter's name: "number" (a place
  // or size that is none or too far, a circle or cell without size), "points" (too few), "cells" (no whole rows),
  // "label" (too long, or not of printable characters), "too_many" (shapes, points or cells).
  std::string_view add(Circle shape);
  std::string_view add(Polygon shape);
  std::string_view add(Line shape);
  std::string_view add(Text shape);
  std::string_view add(Raster shape);
  void clear() { *this = {}; }

  bool empty() const { return size() == 0; }
  std::size_t size() const {
    return rasters_.size() + polygons_.size() + circles_.size() + lines_.size() + texts_.size();
  }
  const std::vector<Raster>& rasters() const { return rasters_; }
  const std::vector<Polygon>& polygons() const { return polygons_; }
  const std::vector<Circle>& circles() const { return circles_; }
  const std::vector<Line>& lines() const { return lines_; }
  const std::vector<Text>& texts() const { return texts_; }

 private:
  std::string_view room(const std::string& label, std::size_t points, std::size_t cells);

  std::vector<Raster> rasters_;
  std::vector<Polygon> polygons_;
  std::vector<Circle> circles_;
  std::vector<Line> lines_;
  std::vector<Text> texts_;
  std::size_t points_ = 0, cells_ = 0;
};

}  // namespace arkmesh::hal
