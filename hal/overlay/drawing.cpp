#include "hal/overlay/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace arkmesh::hal {
namespace {

constexpr std::string_view is_fine, no_number = "number";

bool is_near(const Point& at) {
  return std::abs(at.x_m) <= Drawing::far_m && std::abs(at.y_m) <= Drawing::far_m;  // false for what is no number
}

bool are_near(const std::vector<Point>& points) {
  return std::all_of(points.begin(), points.end(), is_near);
}

bool is_length(double length_m) {
  return length_m > 0 && length_m <= Drawing::far_m;
}

}  // namespace

bool Drawing::is_label(std::string_view text) {
  return text.size() <= max_label && std::all_of(text.begin(), text.end(), [](char c) {
           return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
         });
}

// Takes room for a shape that is good otherwise.
std::string_view Drawing::room(const std::string& label, std::size_t points, std::size_t cells) {
  if (!is_label(label)) return "label";
  if (size() >= max_shapes || points > max_points - points_ || cells > max_cells - cells_) return "too_many";
  points_ += points;
  cells_ += cells;
  return is_fine;
}

std::string_view Drawing::add(Circle shape) {
  if (!is_near(shape.at) || !is_length(shape.radius_m)) return no_number;
  const std::string_view why = room(shape.label, 1, 0);
  if (why.empty()) circles_.push_back(std::move(shape));
  return why;
}

std::string_view Drawing::add(Polygon shape) {
  if (shape.corners.size() < 3) return "points";
  if (!are_near(shape.corners)) return no_number;
  const std::string_view why = room(shape.label, shape.corners.size(), 0);
  if (why.empty()) polygons_.push_back(std::move(shape));
  return why;
}

std::string_view Drawing::add(Line shape) {
  if (shape.points.size() < 2) return "points";
  if (!are_near(shape.points)) return no_number;
  const std::string_view why = room(shape.label, shape.points.size(), 0);
  if (why.empty()) lines_.push_back(std::move(shape));
  return why;
}

std::string_view Drawing::add(Text shape) {
  if (!is_near(shape.at)) return no_number;
  const std::string_view why = room(shape.text, 1, 0);
  if (why.empty()) texts_.push_back(std::move(shape));
  return why;
}

std::string_view Drawing::add(Raster shape) {
  if (!is_near({shape.corner.x_m, shape.corner.y_m}) || !std::isfinite(shape.corner.heading_rad) ||
      !is_length(shape.cell_m))
    return no_number;
  if (shape.columns < 1 || shape.cells.empty() || shape.cells.size() % static_cast<std::size_t>(shape.columns) != 0)
    return "cells";
  const std::string_view why = room(shape.label, 1, shape.cells.size());
  if (why.empty()) rasters_.push_back(std::move(shape));
  return why;
}

}  // namespace arkmesh::hal
