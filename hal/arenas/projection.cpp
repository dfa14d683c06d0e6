#include "hal/arenas/projection.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "hal/fixed_math.hpp"

namespace arkmesh::hal {
namespace {

double wrap(double angle_rad) {
  if (angle_rad > -std::numbers::pi && angle_rad <= std::numbers::pi) return angle_rad;
  const double wrapped = std::remainder(angle_rad, 2 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

// Cosine and sine; most labs are not turned.
std::pair<double, double> direction(double turn_rad) {
  return turn_rad == 0 ? std::pair(1.0, 0.0) : std::pair(fixed::cos(turn_rad), fixed::sin(turn_rad));
}

}  // namespace

Pose Projection::to_shared(const Pose& in_arena) const {
  const auto [c, s] = direction(turn_rad);
  return {shift_x_m + scale * (c * in_arena.x_m - s * in_arena.y_m),
          shift_y_m + scale * (s * in_arena.x_m + c * in_arena.y_m), wrap(in_arena.heading_rad + turn_rad)};
}

Pose Projection::to_arena(const Pose& in_shared) const {
  const auto [c, s] = direction(turn_rad);
  const double x_m = (in_shared.x_m - shift_x_m) / scale, y_m = (in_shared.y_m - shift_y_m) / scale;
  return {c * x_m + s * y_m, -s * x_m + c * y_m, wrap(in_shared.heading_rad - turn_rad)};
}

}  // namespace arkmesh::hal
