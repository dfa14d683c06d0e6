// What stands in the way of light in the arena: shapes that block lamps and infrared wholly, whatever their height.
// Robots' bodies are no shapes; InfraredMedium counts them by itself. Arena frame, metres.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::sim_ode {

using hal::Point;

struct Blocker {
  Point centre;                // of a circle round the whole shape
  double radius_m = 0;         // of that circle
  std::vector<Point> corners;  // of a convex polygon in either order; none: the circle is the shape, a disc

  static Blocker disc(Point centre, double radius_m) { return {centre, radius_m, {}}; }
  static Blocker polygon(std::vector<Point> corners) {
    Blocker out{.corners = std::move(corners)};
    for (const Point& corner : out.corners) {
      out.centre.x_m += corner.x_m / static_cast<double>(out.corners.size());
      out.centre.y_m += corner.y_m / static_cast<double>(out.corners.size());
    }
    for (const Point& corner : out.corners)
      out.radius_m = std::max(out.radius_m, std::hypot(corner.x_m - out.centre.x_m, corner.y_m - out.centre.y_m));
    return out;
  }
};

// What a line may pass of a shape and count as grazing it, which blocks nothing.
inline constexpr double grazing_m = 1e-9;

// Whether the straight line from p to q comes nearer to the centre than radius_m.
inline bool meets_disc(const Point& centre, double radius_m, const Point& p, const Point& q) {
  const double along_x = q.x_m - p.x_m, along_y = q.y_m - p.y_m, x = centre.x_m - p.x_m, y = centre.y_m - p.y_m;
  const double length2 = along_x * along_x + along_y * along_y;
  const double share = length2 > 0 ? std::clamp((x * along_x + y * along_y) / length2, 0.0, 1.0) : 0;
  const double off_x = x - share * along_x, off_y = y - share * along_y, near_m = radius_m - grazing_m;
  return near_m > 0 && off_x * off_x + off_y * off_y < near_m * near_m;
}

// Whether it passes through the inside of a convex polygon: some of it lies inside of all edges.
inline bool meets_polygon(const std::vector<Point>& corners, const Point& p, const Point& q) {
  double area = 0;  // twice; negative when corners go clockwise
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    area += (corners[i].x_m - corners[0].x_m) * (corners[i + 1].y_m - corners[0].y_m) -
            (corners[i].y_m - corners[0].y_m) * (corners[i + 1].x_m - corners[0].x_m);
  double from = 0, to = 1;  // shares of the line
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point &a = corners[i], &b = corners[i + 1 < corners.size() ? i + 1 : 0];
    const double x = b.x_m - a.x_m, y = b.y_m - a.y_m, edge_m = std::sqrt(x * x + y * y);
    if (edge_m == 0) continue;
    // how far each end is inside of this edge
    const double scale = (area < 0 ? -1 : 1) / edge_m;
    const double in_p = scale * (x * (p.y_m - a.y_m) - y * (p.x_m - a.x_m)) - grazing_m,
                 in_q = scale * (x * (q.y_m - a.y_m) - y * (q.x_m - a.x_m)) - grazing_m;
    if (in_p <= 0 && in_q <= 0) return false;
    if (in_p < 0)
      from = std::max(from, in_p / (in_p - in_q));
    else if (in_q < 0)
      to = std::min(to, in_p / (in_p - in_q));
  }
  return corners.size() > 2 && from < to;
}

// The shapes of now. Who owns it keeps it up to date; who asks sees it as it is.
struct Shadows {
  std::vector<Blocker> blockers;

  // Whether anything stands between p and q. Touching is not between.
  bool between(const Point& p, const Point& q) const {
    return std::ranges::any_of(blockers, [&](const Blocker& blocker) {
      return meets_disc(blocker.centre, blocker.radius_m, p, q) &&
             (blocker.corners.empty() || meets_polygon(blocker.corners, p, q));
    });
  }
};

}  // namespace arkmesh::sim_ode
