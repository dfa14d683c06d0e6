#include "scenarios/kit/region.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "scenarios/kit/bearing.hpp"

namespace arkmesh::scenarios::kit {
namespace {

using hal::Point;

// Twice the area of a triangle; positive when it turns left.
double turn(const Point& a, const Point& b, const Point& c) {
  return (b.x_m - a.x_m) * (c.y_m - a.y_m) - (b.y_m - a.y_m) * (c.x_m - a.x_m);
}

bool is_between(const Point& a, const Point& b, const Point& p) {
  return std::min(a.x_m, b.x_m) <= p.x_m && p.x_m <= std::max(a.x_m, b.x_m) && std::min(a.y_m, b.y_m) <= p.y_m &&
         p.y_m <= std::max(a.y_m, b.y_m);
}

// Whether two sides have a point in common.
bool meet(const Point& a, const Point& b, const Point& c, const Point& d) {
  const double abc = turn(a, b, c), abd = turn(a, b, d), cda = turn(c, d, a), cdb = turn(c, d, b);
  if (((abc > 0) != (abd > 0)) && ((cda > 0) != (cdb > 0)) && abc != 0 && abd != 0 && cda != 0 && cdb != 0) return true;
  return (abc == 0 && is_between(a, b, c)) || (abd == 0 && is_between(a, b, d)) || (cda == 0 && is_between(c, d, a)) ||
         (cdb == 0 && is_between(c, d, b));
}

bool crosses_itself(const std::vector<Point>& corners) {
  const std::size_t n = corners.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = i + 2; k < n; ++k)
      if (!(i == 0 && k + 1 == n) && meet(corners[i], corners[i + 1], corners[k], corners[(k + 1) % n])) return true;
  return false;
}

double signed_area_m2(const std::vector<Point>& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    twice += a.x_m * b.y_m - b.x_m * a.y_m;
  }
  return twice / 2;
}

}  // namespace

Region Region::disc(const Point& centre, double radius_m) {
  if (!(radius_m > 0) || !std::isfinite(radius_m) || !std::isfinite(centre.x_m) || !std::isfinite(centre.y_m))
    throw std::invalid_argument(fmt::format("a disc of radius {} m is not a region; give a positive radius", radius_m));
  Region out;
  out.shape_.radius_m = radius_m;
  out.centre_ = centre;
  return out;
}

Region Region::polygon(std::vector<Point> corners) {
  if (corners.size() < 3)
    throw std::invalid_argument(fmt::format("a polygon needs at least 3 corners, not {}", corners.size()));
  if (std::ranges::any_of(corners, [](const Point& p) { return !std::isfinite(p.x_m) || !std::isfinite(p.y_m); }))
    throw std::invalid_argument("a polygon's corners must be numbers, not NaN");
  if (crosses_itself(corners)) throw std::invalid_argument("a polygon's sides cross; give its corners in order");
  if (signed_area_m2(corners) == 0) throw std::invalid_argument("a polygon without area is not a region");
  Region out;
  out.shape_.corners = std::move(corners);
  return out;
}

bool Region::contains(const Point& place) const {
  if (shape_.radius_m > 0) return distance2_m2(place, centre_) <= shape_.radius_m * shape_.radius_m;
  // an odd number of sides lies to the right
  bool inside = false;
  const auto& corners = shape_.corners;
  for (std::size_t i = 0, k = corners.size() - 1; i < corners.size(); k = i++) {
    const Point &a = corners[i], &b = corners[k];
    if ((a.y_m > place.y_m) != (b.y_m > place.y_m) &&
        place.x_m < (b.x_m - a.x_m) * (place.y_m - a.y_m) / (b.y_m - a.y_m) + a.x_m)
      inside = !inside;
  }
  return inside;
}

double Region::area_m2() const {
  if (shape_.radius_m > 0) return std::numbers::pi * shape_.radius_m * shape_.radius_m;
  return std::abs(signed_area_m2(shape_.corners));
}

Region Region::seen_in(const hal::Projection& arena) const {
  const auto seen = [&](const Point& p) {
    const hal::Pose at = arena.to_arena({p.x_m, p.y_m, 0});
    return Point{at.x_m, at.y_m};
  };
  Region out = *this;
  out.centre_ = seen(centre_);
  out.shape_.radius_m /= arena.scale;
  for (Point& corner : out.shape_.corners) corner = seen(corner);
  return out;
}

void Region::draw(lab::Lab& lab, hal::Colour colour, bool filled, const std::string& label) const {
  if (shape_.radius_m > 0)
    lab.draw(
        hal::Circle{.at = centre_, .radius_m = shape_.radius_m, .colour = colour, .filled = filled, .label = label});
  else
    lab.draw(hal::Polygon{.corners = shape_.corners, .colour = colour, .filled = filled, .label = label});
}

Schedule::Schedule(std::vector<Change> changes) : changes_(std::move(changes)) {
  if (changes_.empty()) throw std::invalid_argument("a schedule needs at least one value");
  if (std::ranges::adjacent_find(changes_, [](const Change& a, const Change& b) { return !(a.from_s < b.from_s); }) !=
      changes_.end())
    throw std::invalid_argument("the times of a schedule must ascend");
}

double Schedule::at(double time_s) const {
  const auto next = std::ranges::upper_bound(changes_, time_s, {}, &Change::from_s);
  return next == changes_.begin() ? next->value : std::prev(next)->value;
}

}  // namespace arkmesh::scenarios::kit
