// The nearest point of a side or disc within a sector is its nearest point of all when that lies in the sector, an end
// of a side that does, or where one of the sector's two edges meets it.
#include "scenarios/kit/sectors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "hal/fixed_math.hpp"

namespace arkmesh::scenarios::kit {
namespace {

namespace fixed = hal::fixed;
using hal::Point;

constexpr double pi = std::numbers::pi;
constexpr double none = std::numeric_limits<double>::infinity();

// A sector of less than half a circle as two directions: what lies left of `right` and right of `left`.
struct Wedge {
  Point right, left;
  bool holds(const Point& p) const {
    return right.x_m * p.y_m - right.y_m * p.x_m >= 0 && left.x_m * p.y_m - left.y_m * p.x_m <= 0;
  }
};

Point direction(double angle_rad) {
  return {fixed::cos(angle_rad), fixed::sin(angle_rad)};
}

double length(const Point& p) {
  return std::sqrt(p.x_m * p.x_m + p.y_m * p.y_m);
}

// Of a side, in any direction.
Point nearest_point(const Point& from, const Point& to) {
  const Point along{to.x_m - from.x_m, to.y_m - from.y_m};
  const double square = along.x_m * along.x_m + along.y_m * along.y_m;
  const double share = square > 0 ? std::clamp(-(from.x_m * along.x_m + from.y_m * along.y_m) / square, 0.0, 1.0) : 0;
  return {from.x_m + share * along.x_m, from.y_m + share * along.y_m};
}

// Places seen from the robot's centre.
double distance_in(const Wedge& wedge, const Point& from, const Point& to) {
  double nearest = none;
  const auto consider = [&](const Point& p) {
    if (wedge.holds(p)) nearest = std::min(nearest, length(p));
  };
  const Point along{to.x_m - from.x_m, to.y_m - from.y_m};
  const double square = along.x_m * along.x_m + along.y_m * along.y_m;
  const double share = square > 0 ? -(from.x_m * along.x_m + from.y_m * along.y_m) / square : 0;
  if (share > 0 && share < 1) consider({from.x_m + share * along.x_m, from.y_m + share * along.y_m});
  consider(from);
  consider(to);
  for (const Point& edge : {wedge.right, wedge.left}) {
    // from + share * along = far * edge
    const double across = along.x_m * edge.y_m - along.y_m * edge.x_m;
    if (across == 0) continue;
    const double at = (from.y_m * edge.x_m - from.x_m * edge.y_m) / across;
    const double far = (from.y_m * along.x_m - from.x_m * along.y_m) / across;
    if (at >= 0 && at <= 1 && far >= 0) nearest = std::min(nearest, far);
  }
  return nearest;
}

double distance_in(const Wedge& wedge, const Point& centre, double radius_m) {
  const double far = length(centre);
  if (far <= radius_m) return 0;
  double nearest = wedge.holds(centre) ? far - radius_m : none;
  for (const Point& edge : {wedge.right, wedge.left}) {
    const double along = centre.x_m * edge.x_m + centre.y_m * edge.y_m;
    const double off2 = far * far - along * along, room = radius_m * radius_m - off2;
    if (along > 0 && room >= 0) nearest = std::min(nearest, along - std::sqrt(room));
  }
  return nearest;
}

}  // namespace

Surroundings::Surroundings(double width_m, double height_m, std::span<const hal::Obstacle> obstacles, double margin_m) {
  const double x = width_m / 2, y = height_m / 2;
  const Point corners[] = {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
  for (int i = 0; i < 4; ++i) sides_.push_back({corners[i], corners[(i + 1) % 4]});
  std::vector<Disc> discs;
  for (const hal::Obstacle& obstacle : obstacles) {
    if (obstacle.shape.radius_m > 0) {
      discs.push_back({{obstacle.pose.x_m, obstacle.pose.y_m}, obstacle.shape.radius_m, margin_m});
      continue;
    }
    const Point turn = direction(obstacle.pose.heading_rad);
    std::vector<Point> placed;
    for (const Point& c : obstacle.shape.corners)
      placed.push_back({obstacle.pose.x_m + turn.x_m * c.x_m - turn.y_m * c.y_m,
                        obstacle.pose.y_m + turn.y_m * c.x_m + turn.x_m * c.y_m});
    for (std::size_t i = 0; i < placed.size(); ++i)
      sides_.push_back({placed[i], placed[(i + 1) % placed.size()], margin_m});
  }
  add_discs(discs);
}

void Surroundings::add_discs(std::span<const Disc> discs) {
  discs_.insert(discs_.end(), discs.begin(), discs.end());
  std::ranges::stable_sort(discs_, {}, [](const Disc& disc) { return disc.centre.x_m; });
  for (const Disc& disc : discs) largest_m_ = std::max(largest_m_, disc.radius_m + disc.margin_m);
}

std::span<const Surroundings::Disc> Surroundings::discs_near(double x_m, double reach_m) const {
  const auto x_of = [](const Disc& disc) { return disc.centre.x_m; };
  const double far_m = reach_m + largest_m_;
  const auto from = std::ranges::lower_bound(discs_, x_m - far_m, {}, x_of);
  return {from, std::ranges::upper_bound(from, discs_.end(), x_m + far_m, {}, x_of)};
}

Sectors::Sectors(const Settings& settings) : settings_(settings) {
  if (settings.count < 1 || settings.count > 16)
    throw std::invalid_argument(fmt::format("a sensor of {} sectors is not possible; give 1 to 16", settings.count));
  if (!(settings.reach_m > 0) || !std::isfinite(settings.reach_m))
    throw std::invalid_argument(fmt::format("a reach of {} m is not possible; give a positive one", settings.reach_m));
  if (settings.levels < 1 || settings.levels > 255)
    throw std::invalid_argument(fmt::format("{} levels are not possible; give 1 to 255", settings.levels));
}

std::vector<double> Sectors::half_planes_m(const hal::Pose& robot, const Surroundings& what) const {
  constexpr double tolerance_rad = 1e-6;  // headings are known to a microradian: head-on means all sectors
  std::vector<double> nearest(static_cast<std::size_t>(settings_.count), none);
  const auto fill = [&](const Point& towards, double far_m) {
    if (!(far_m < settings_.reach_m)) return;
    const double bearing = fixed::atan2(towards.y_m, towards.x_m) - robot.heading_rad;
    const auto blocked = [&](int edge) {
      return std::abs(std::remainder(pi / 2 - edge * pi / settings_.count - bearing, 2 * pi)) <= pi / 2 + tolerance_rad;
    };
    for (int i = 0; i < settings_.count; ++i)
      if (double& here = nearest[static_cast<std::size_t>(i)]; blocked(i) && blocked(i + 1))
        here = std::min(here, far_m);
  };
  const auto seen = [&](const Point& p) { return Point{p.x_m - robot.x_m, p.y_m - robot.y_m}; };
  Point rest{};
  double rest_m = none;
  for (std::size_t i = 0; i < what.sides().size(); ++i) {
    const Surroundings::Side& side = what.sides()[i];
    const Point at = nearest_point(seen(side.from), seen(side.to));
    const double far_m = std::max(0.0, length(at) - side.margin_m);
    if (i < 4) fill(at, far_m);  // a wall
    if (i >= 4 && far_m < rest_m) rest = at, rest_m = far_m;
  }
  for (const Surroundings::Disc& disc : what.discs_near(robot.x_m, settings_.reach_m)) {
    const double far_m = std::max(0.0, length(seen(disc.centre)) - disc.radius_m - disc.margin_m);
    if (far_m < rest_m) rest = seen(disc.centre), rest_m = far_m;
  }
  fill(rest, rest_m);
  return nearest;
}

std::vector<double> Sectors::distances_m(const hal::Pose& robot, const Surroundings& what) const {
  if (settings_.half_planes) return half_planes_m(robot, what);
  std::vector<double> nearest(static_cast<std::size_t>(settings_.count), none);
  const double wide = (settings_.around ? 2 * pi : pi) / settings_.count;
  // A wedge is less than half a circle, so that a wide sector is several.
  const int parts = wide > 0.9 * pi ? 4 : 1;
  const int wedges = settings_.count * parts;
  std::vector<Point> edges;  // of wedges, counter-clockwise
  const double part = wide / parts, right = robot.heading_rad - (settings_.around ? 0 : pi / 2);
  for (int i = 0; i <= wedges; ++i) edges.push_back(direction(right + i * part));
  const auto seen = [&](const Point& p) { return Point{p.x_m - robot.x_m, p.y_m - robot.y_m}; };
  const auto look = [&](double margin_m, const auto& thing) {
    for (int i = 0; i < wedges; ++i) {
      const int sector = (settings_.around ? i : wedges - 1 - i) / parts;
      const auto at = static_cast<std::size_t>(i);
      double& here = nearest[static_cast<std::size_t>(sector)];
      here = std::min(here, std::max(0.0, thing({edges[at], edges[at + 1]}) - margin_m));
    }
  };
  // most things are out of reach
  for (const auto& side : what.sides()) {
    const Point from = seen(side.from), to = seen(side.to);
    if (length(nearest_point(from, to)) - side.margin_m <= settings_.reach_m)
      look(side.margin_m, [&](const Wedge& wedge) { return distance_in(wedge, from, to); });
  }
  for (const auto& disc : what.discs_near(robot.x_m, settings_.reach_m)) {
    const Point centre = seen(disc.centre);
    if (length(centre) - disc.radius_m - disc.margin_m <= settings_.reach_m)
      look(disc.margin_m, [&](const Wedge& wedge) { return distance_in(wedge, centre, disc.radius_m); });
  }
  for (double& d : nearest)
    if (d > settings_.reach_m) d = none;
  return nearest;
}

std::vector<int> Sectors::levels(const hal::Pose& robot, const Surroundings& what) const {
  std::vector<int> out;
  for (const double d : distances_m(robot, what))
    out.push_back(d > settings_.reach_m
                      ? 0
                      : std::max(1, static_cast<int>(std::ceil(settings_.levels * (1 - d / settings_.reach_m)))));
  return out;
}

std::uint32_t Sectors::bits(std::span<const int> levels) {
  std::uint32_t out = 0;
  for (const int level : levels) out = out << 1 | (level > 0 ? 1 : 0);
  return out;
}

}  // namespace arkmesh::scenarios::kit
