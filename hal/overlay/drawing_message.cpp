#include "hal/overlay/drawing_message.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "hal/bus/bus.hpp"

namespace arkmesh::hal {
namespace {

std::string name_of(Colour colour) {
  return std::string(look_of(colour).name);
}

template <class List>
std::int32_t count_of(const List& list) {
  return static_cast<std::int32_t>(list.size());
}

std::vector<point_t> points_of(const std::vector<Point>& points) {
  std::vector<point_t> out(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) out[i].x_m = points[i].x_m, out[i].y_m = points[i].y_m;
  return out;
}

std::vector<Point> points_of(const std::vector<point_t>& points) {
  std::vector<Point> out;
  out.reserve(points.size());
  for (const point_t& point : points) out.push_back({point.x_m, point.y_m});
  return out;
}

}  // namespace

overlay_t to_message(const Drawing& drawing, LabTime stamp) {
  overlay_t out;
  out.stamp_us = stamp.count();
  for (const Raster& raster : drawing.rasters()) {
    overlay_raster_t& m = out.rasters.emplace_back();
    m.x_m = raster.corner.x_m, m.y_m = raster.corner.y_m, m.heading_rad = raster.corner.heading_rad;
    m.cell_m = raster.cell_m;
    m.columns = raster.columns;
    m.n_cells = count_of(raster.cells);
    m.rows = m.n_cells / m.columns;
    m.cells = raster.cells;
    m.colour = name_of(raster.colour);
    m.label = raster.label;
  }
  for (const Polygon& polygon : drawing.polygons()) {
    overlay_polygon_t& m = out.polygons.emplace_back();
    m.n_corners = count_of(polygon.corners);
    m.corners = points_of(polygon.corners);
    m.colour = name_of(polygon.colour);
    m.filled = polygon.filled, m.dashed = polygon.dashed;
    m.label = polygon.label;
  }
  for (const Circle& circle : drawing.circles()) {
    overlay_circle_t& m = out.circles.emplace_back();
    m.x_m = circle.at.x_m, m.y_m = circle.at.y_m, m.radius_m = circle.radius_m;
    m.colour = name_of(circle.colour);
    m.filled = circle.filled, m.dashed = circle.dashed;
    m.label = circle.label;
  }
  for (const Line& line : drawing.lines()) {
    overlay_line_t& m = out.lines.emplace_back();
    m.n_points = count_of(line.points);
    m.points = points_of(line.points);
    m.colour = name_of(line.colour);
    m.dashed = line.dashed;
    m.label = line.label;
  }
  for (const Text& text : drawing.texts()) {
    overlay_text_t& m = out.texts.emplace_back();
    m.x_m = text.at.x_m, m.y_m = text.at.y_m;
    m.colour = name_of(text.colour);
    m.text = text.text;
  }
  out.n_rasters = count_of(out.rasters);
  out.n_polygons = count_of(out.polygons);
  out.n_circles = count_of(out.circles);
  out.n_lines = count_of(out.lines);
  out.n_texts = count_of(out.texts);
  return out;
}

bool read_overlay(std::span<const std::byte> bytes, Drawing& drawing, Counters& refused) {
  const auto count = [&](std::string_view why) {
    if (!why.empty()) refused.add("overlay.refused." + std::string(why));
  };
  overlay_t message;
  if (const std::string_view why = read_message(bytes, message); !why.empty()) return count(why), false;
  drawing.clear();
  for (overlay_raster_t& m : message.rasters) {
    const bool whole = m.columns >= 1 && m.rows >= 1 && std::int64_t{m.columns} * m.rows == m.n_cells;
    count(drawing.add(Raster{{m.x_m, m.y_m, m.heading_rad},
                             m.cell_m,
                             whole ? m.columns : 0,
                             std::move(m.cells),
                             colour_named(m.colour),
                             std::move(m.label)}));
  }
  for (overlay_polygon_t& m : message.polygons)
    count(drawing.add(
        Polygon{points_of(m.corners), colour_named(m.colour), m.filled != 0, m.dashed != 0, std::move(m.label)}));
  for (overlay_circle_t& m : message.circles)
    count(drawing.add(
        Circle{{m.x_m, m.y_m}, m.radius_m, colour_named(m.colour), m.filled != 0, m.dashed != 0, std::move(m.label)}));
  for (overlay_line_t& m : message.lines)
    count(drawing.add(Line{points_of(m.points), colour_named(m.colour), m.dashed != 0, std::move(m.label)}));
  for (overlay_text_t& m : message.texts)
    count(drawing.add(Text{{m.x_m, m.y_m}, std::move(m.text), colour_named(m.colour)}));
  return true;
}

}  // namespace arkmesh::hal
