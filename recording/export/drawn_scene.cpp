#include "recording/export/drawn_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "recording/export/proto.hpp"

namespace arkmesh::recording::scene {
namespace {

using foxglove::LinePrimitive;
using Corners = std::vector<hal::Point>;

// Heights, so that what lies over something is seen.
constexpr double raster_z_m = 0.0002, polygon_z_m = 0.0004, circle_z_m = 0.0006, line_z_m = 0.001;

Colour scene_colour(hal::Colour colour, double opacity = 1) {
  const std::uint32_t rgb = hal::look_of(colour).dark;
  const auto part = [&](int bits) { return std::round(static_cast<double>(rgb >> bits & 0xff) / 0.255) / 1000; };
  return {part(16), part(8), part(0), std::round(opacity * 1000) / 1000};
}

Point point_at(const hal::Point& at, double z_m) {
  return {place(at.x_m), place(at.y_m), z_m};
}

std::vector<Point> points_at(const Corners& corners, double z_m) {
  std::vector<Point> out;
  for (const hal::Point& corner : corners) out.push_back(point_at(corner, z_m));
  return out;
}

Corners corners_of(const hal::Circle& circle) {
  constexpr int steps = 36;
  Corners out;
  for (int i = 0; i < steps; ++i) {
    const double angle = 2 * std::numbers::pi * i / steps;
    out.push_back(
        {circle.at.x_m + circle.radius_m * std::cos(angle), circle.at.y_m + circle.radius_m * std::sin(angle)});
  }
  return out;
}

double cross(const hal::Point& a, const hal::Point& b, const hal::Point& c) {
  return (b.x_m - a.x_m) * (c.y_m - a.y_m) - (b.y_m - a.y_m) * (c.x_m - a.x_m);
}

// Cuts off one ear after the other; what crosses itself is cut as far as it has ears.
std::vector<std::uint32_t> triangulated(const Corners& corners) {
  std::vector<std::size_t> left(corners.size());
  double area = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    left[i] = i;
    area += cross({0, 0}, corners[i], corners[(i + 1) % corners.size()]);
  }
  if (area < 0) std::reverse(left.begin(), left.end());
  std::vector<std::uint32_t> indices;
  const auto is_ear = [&](std::size_t i) {
    const std::size_t n = left.size(), a = left[(i + n - 1) % n], b = left[i], c = left[(i + 1) % n];
    if (cross(corners[a], corners[b], corners[c]) <= 0) return false;
    return std::none_of(left.begin(), left.end(), [&](std::size_t other) {
      const hal::Point& p = corners[other];
      return other != a && other != b && other != c && cross(corners[a], corners[b], p) >= 0 &&
             cross(corners[b], corners[c], p) >= 0 && cross(corners[c], corners[a], p) >= 0;
    });
  };
  while (left.size() > 2) {
    std::optional<std::size_t> ear;
    for (std::size_t i = 0; i < left.size() && !ear; ++i)
      if (is_ear(i)) ear = i;
    if (!ear) break;
    const std::size_t n = left.size();
    for (std::size_t corner : {left[(*ear + n - 1) % n], left[*ear], left[(*ear + 1) % n]})
      indices.push_back(static_cast<std::uint32_t>(corner));
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(*ear));
  }
  return indices;
}

void fill(foxglove::SceneEntity& to, const Corners& corners, hal::Colour colour, double z_m) {
  constexpr std::size_t most = 64;
  if (corners.size() > most) return;
  add_triangles(to, points_at(corners, z_m), triangulated(corners), scene_colour(colour, hal::fill_opacity));
}

void stroke(foxglove::SceneEntity& to, const Corners& corners, bool closed, bool dashed, hal::Colour colour,
            double z_m) {
  if (!dashed) {
    add_line(to, closed ? LinePrimitive::LINE_LOOP : LinePrimitive::LINE_STRIP, points_at(corners, z_m),
             scene_colour(colour));
    return;
  }
  double whole_m = 0;
  const std::size_t edges = corners.size() - (closed ? 0 : 1);
  const auto length_m = [&](std::size_t edge) {
    const hal::Point &from = corners[edge], &to = corners[(edge + 1) % corners.size()];
    return std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
  };
  for (std::size_t edge = 0; edge < edges; ++edge) whole_m += length_m(edge);
  // An odd number of pieces on each edge, every second one drawn: corners stay. About 40 dashes in all.
  std::vector<Point> points;
  for (std::size_t edge = 0; edge < edges; ++edge) {
    const hal::Point &from = corners[edge], &to = corners[(edge + 1) % corners.size()];
    const int dashes = whole_m > 0 ? static_cast<int>(40 * length_m(edge) / whole_m) : 0, pieces = 2 * dashes + 1;
    for (int piece = 0; piece < pieces; piece += 2)
      for (int end : {piece, piece + 1}) {
        // Of edges as short as a dash, half is drawn.
        const double part = static_cast<double>(end) / (pieces == 1 ? 2 : pieces);
        points.push_back(point_at({from.x_m + (to.x_m - from.x_m) * part, from.y_m + (to.y_m - from.y_m) * part}, z_m));
      }
  }
  add_line(to, LinePrimitive::LINE_LIST, points, scene_colour(colour));
}

void label(foxglove::SceneEntity& to, const hal::Point& at, const std::string& text, hal::Colour colour) {
  if (!text.empty()) add_words(to, place(at.x_m), place(at.y_m), utf8(text), scene_colour(colour));
}

hal::Point on_raster(const hal::Raster& raster, double columns, double rows) {
  const double c = std::cos(raster.corner.heading_rad), s = std::sin(raster.corner.heading_rad);
  const double along_m = columns * raster.cell_m, left_m = rows * raster.cell_m;
  return {raster.corner.x_m + c * along_m - s * left_m, raster.corner.y_m + s * along_m + c * left_m};
}

// Squares of so many cells that there are at most 48 of them along a side.
void draw_raster(foxglove::SceneEntity& to, const hal::Raster& raster) {
  constexpr std::size_t most = 48;
  const auto columns = static_cast<std::size_t>(raster.columns), rows = raster.cells.size() / columns;
  const std::size_t size = (std::max(columns, rows) + most - 1) / most;
  std::vector<Point> points;
  std::vector<Colour> colours;
  std::vector<std::uint32_t> indices;
  for (std::size_t row = 0; row < rows; row += size)
    for (std::size_t column = 0; column < columns; column += size) {
      const std::size_t row_end = std::min(row + size, rows), column_end = std::min(column + size, columns);
      double sum = 0;
      for (std::size_t r = row; r < row_end; ++r)
        for (std::size_t c = column; c < column_end; ++c) sum += raster.cells[r * columns + c];
      if (sum == 0) continue;
      const double mean = sum / static_cast<double>((row_end - row) * (column_end - column));
      const std::size_t first = points.size();
      const Colour colour = scene_colour(raster.colour, hal::raster_opacity * mean / 255);
      for (const auto& [c, r] : {std::pair{column, row}, std::pair{column_end, row}, std::pair{column_end, row_end},
                                 std::pair{column, row_end}}) {
        points.push_back(point_at(on_raster(raster, static_cast<double>(c), static_cast<double>(r)), raster_z_m));
        colours.push_back(colour);
      }
      for (std::size_t corner : {0, 1, 2, 0, 2, 3}) indices.push_back(static_cast<std::uint32_t>(first + corner));
    }
  if (!points.empty()) add_triangles(to, points, indices, scene_colour(raster.colour), colours);
  label(to, on_raster(raster, static_cast<double>(columns) / 2, static_cast<double>(rows)), raster.label,
        raster.colour);
}

}  // namespace

void draw(foxglove::SceneEntity& to, const hal::Drawing& drawing) {
  for (const hal::Raster& raster : drawing.rasters()) draw_raster(to, raster);
  for (const hal::Polygon& polygon : drawing.polygons()) {
    if (polygon.filled) fill(to, polygon.corners, polygon.colour, polygon_z_m);
    stroke(to, polygon.corners, true, polygon.dashed, polygon.colour, polygon_z_m);
    hal::Point mean;
    for (const hal::Point& corner : polygon.corners) mean.x_m += corner.x_m, mean.y_m += corner.y_m;
    const auto n = static_cast<double>(polygon.corners.size());
    label(to, {mean.x_m / n, mean.y_m / n}, polygon.label, polygon.colour);
  }
  for (const hal::Circle& circle : drawing.circles()) {
    const Corners corners = corners_of(circle);
    if (circle.filled) fill(to, corners, circle.colour, circle_z_m);
    stroke(to, corners, true, circle.dashed, circle.colour, circle_z_m);
    label(to, {circle.at.x_m, circle.at.y_m + circle.radius_m}, circle.label, circle.colour);
  }
  for (const hal::Line& drawn : drawing.lines()) {
    stroke(to, drawn.points, false, drawn.dashed, drawn.colour, line_z_m);
    label(to, drawn.points[drawn.points.size() / 2], drawn.label, drawn.colour);
  }
  for (const hal::Text& text : drawing.texts()) label(to, text.at, text.text, text.colour);
}

}  // namespace arkmesh::recording::scene
