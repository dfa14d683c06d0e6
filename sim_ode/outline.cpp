#include "sim_ode/outline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hal/fixed_math.hpp"

namespace arkmesh::sim_ode {
namespace {

// Cells along each side of the square in which a polygon's mean distance is counted.
constexpr int cells = 64;

}  // namespace

Outline::Outline(hal::Shape shape) : shape_(std::move(shape)) {
  const std::vector<hal::Point>& corners = shape_.corners;
  bound_m_ = shape_.radius_m;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const hal::Point &from = corners[i], &to = corners[(i + 1) % corners.size()];
    const double x = to.x_m - from.x_m, y = to.y_m - from.y_m, length = std::sqrt(x * x + y * y);
    if (length > 0) sides_.push_back({from.x_m, from.y_m, x / length, y / length, length});
    bound_m_ = std::max(bound_m_, std::sqrt(from.x_m * from.x_m + from.y_m * from.y_m));
  }
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const Side &side = sides_[i], &next = sides_[(i + 1) % sides_.size()];
    if (side.ahead_x * next.ahead_y - side.ahead_y * next.ahead_x < 0) convex_ = false;
  }
  measure();
}

void Outline::measure() {
  if (is_disc()) {
    gyration_m2_ = shape_.radius_m * shape_.radius_m / 2;
    mean_distance_m_ = shape_.radius_m * 2 / 3;
    return;
  }
  // triangles between the origin and each side
  double area = 0, x = 0, y = 0, second = 0;
  const std::vector<hal::Point>& corners = shape_.corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const hal::Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const double twice = a.x_m * b.y_m - b.x_m * a.y_m;
    area += twice / 2;
    x += twice * (a.x_m + b.x_m) / 6;
    y += twice * (a.y_m + b.y_m) / 6;
    second +=
        twice * (a.x_m * a.x_m + a.x_m * b.x_m + b.x_m * b.x_m + a.y_m * a.y_m + a.y_m * b.y_m + b.y_m * b.y_m) / 12;
  }
  centre_ = {x / area, y / area};
  gyration_m2_ = second / area - centre_.x_m * centre_.x_m - centre_.y_m * centre_.y_m;
  double sum = 0;
  int count = 0;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      const double px = bound_m_ * (2 * (i + 0.5) / cells - 1), py = bound_m_ * (2 * (j + 0.5) / cells - 1);
      if (!inside(px, py)) continue;
      sum += std::sqrt((px - centre_.x_m) * (px - centre_.x_m) + (py - centre_.y_m) * (py - centre_.y_m));
      ++count;
    }
  // a needle may lie between the cells' centres
  mean_distance_m_ = count > 0 ? sum / count : std::sqrt(std::max(0.0, gyration_m2_));
}

bool Outline::inside(double x, double y) const {
  bool out = false;
  const std::vector<hal::Point>& corners = shape_.corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const hal::Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    if ((a.y_m > y) == (b.y_m > y)) continue;
    if (x < a.x_m + (y - a.y_m) * (b.x_m - a.x_m) / (b.y_m - a.y_m)) out = !out;
  }
  return out;
}

void Outline::touches(double x, double y, double radius_m, double reach_m, std::vector<Touch>& out) const {
  if (is_disc()) {
    const double d = std::sqrt(x * x + y * y), gap = d - shape_.radius_m - radius_m;
    if (gap >= reach_m) return;
    const double nx = d > 0 ? x / d : 1, ny = d > 0 ? y / d : 0;
    out.push_back({gap, nx, ny, nx * shape_.radius_m, ny * shape_.radius_m});
    return;
  }
  if (inside(x, y)) {
    // out by the shortest way
    Touch nearest{-std::numeric_limits<double>::infinity(), 0, 0, 0, 0};
    for (const Side& side : sides_) {
      const double along = std::clamp((x - side.x) * side.ahead_x + (y - side.y) * side.ahead_y, 0.0, side.length_m);
      const double px = side.x + along * side.ahead_x, py = side.y + along * side.ahead_y;
      const double gap = -std::sqrt((x - px) * (x - px) + (y - py) * (y - py)) - radius_m;
      if (gap > nearest.gap_m) nearest = {gap, side.ahead_y, -side.ahead_x, px, py};
    }
    out.push_back(nearest);
    return;
  }
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const Side &side = sides_[i], &before = sides_[i > 0 ? i - 1 : sides_.size() - 1];
    const double dx = x - side.x, dy = y - side.y, along = dx * side.ahead_x + dy * side.ahead_y;
    if (along > 0 && along < side.length_m) {
      const double d = dx * side.ahead_y - dy * side.ahead_x;
      if (d >= 0 && d - radius_m < reach_m)
        out.push_back({d - radius_m, side.ahead_y, -side.ahead_x, x - d * side.ahead_y, y + d * side.ahead_x});
    } else if (along <= 0 && dx * before.ahead_x + dy * before.ahead_y >= 0) {
      // the corner between the two sides is nearest
      const double d = std::sqrt(dx * dx + dy * dy);
      if (d - radius_m >= reach_m) continue;
      const double nx = d > 0 ? dx / d : side.ahead_y, ny = d > 0 ? dy / d : -side.ahead_x;
      out.push_back({d - radius_m, nx, ny, side.x, side.y});
    }
  }
}

double Outline::distance_m(double x, double y) const {
  if (is_disc()) return std::sqrt(x * x + y * y) - shape_.radius_m;
  double nearest2 = std::numeric_limits<double>::infinity();
  for (const Side& side : sides_) {
    const double along = std::clamp((x - side.x) * side.ahead_x + (y - side.y) * side.ahead_y, 0.0, side.length_m);
    const double dx = x - side.x - along * side.ahead_x, dy = y - side.y - along * side.ahead_y;
    nearest2 = std::min(nearest2, dx * dx + dy * dy);
  }
  return inside(x, y) ? -std::sqrt(nearest2) : std::sqrt(nearest2);
}

PlacedOutline place(const Outline& outline, const hal::Pose& pose) {
  return {&outline, pose.x_m, pose.y_m, hal::fixed::cos(pose.heading_rad), hal::fixed::sin(pose.heading_rad)};
}

void PlacedOutline::touches(double at_x, double at_y, double radius_m, double reach_m,
                            std::vector<Outline::Touch>& out) const {
  const std::size_t first = out.size();
  const double dx = at_x - x, dy = at_y - y;
  outline->touches(cos * dx + sin * dy, cos * dy - sin * dx, radius_m, reach_m, out);
  for (std::size_t i = first; i < out.size(); ++i) {
    Outline::Touch& touch = out[i];
    touch = {touch.gap_m, cos * touch.normal_x - sin * touch.normal_y, sin * touch.normal_x + cos * touch.normal_y,
             x + cos * touch.x - sin * touch.y, y + sin * touch.x + cos * touch.y};
  }
}

double PlacedOutline::distance_m(double at_x, double at_y) const {
  const double dx = at_x - x, dy = at_y - y;
  return outline->distance_m(cos * dx + sin * dy, cos * dy - sin * dx);
}

hal::Point PlacedOutline::corner(std::size_t i) const {
  const hal::Point& own = outline->shape().corners[i];
  return {x + cos * own.x_m - sin * own.y_m, y + sin * own.x_m + cos * own.y_m};
}

void touches_of(const PlacedOutline& one, const PlacedOutline& other, double reach_m,
                std::vector<Outline::Touch>& out) {
  if (one.outline->is_disc()) return other.touches(one.x, one.y, one.outline->shape().radius_m, reach_m, out);
  if (!other.outline->is_disc())
    for (std::size_t i = 0; i < one.corners(); ++i) {
      const hal::Point corner = one.corner(i);
      other.touches(corner.x_m, corner.y_m, 0, reach_m, out);
    }
  // and the other way round
  const std::size_t first = out.size();
  if (other.outline->is_disc()) {
    one.touches(other.x, other.y, other.outline->shape().radius_m, reach_m, out);
  } else {
    for (std::size_t i = 0; i < other.corners(); ++i) {
      const hal::Point corner = other.corner(i);
      one.touches(corner.x_m, corner.y_m, 0, reach_m, out);
    }
  }
  for (std::size_t i = first; i < out.size(); ++i) {
    out[i].normal_x = -out[i].normal_x;
    out[i].normal_y = -out[i].normal_y;
  }
}

}  // namespace arkmesh::sim_ode
