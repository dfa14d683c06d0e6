// One after the other at random; a crowd too dense for that stands on a square grid, each on a random place of it.
#include "sim_ode/start_places.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "hal/fixed_math.hpp"
#include "sim_ode/neighbour_grid.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double rounding_m = 1e-6;
constexpr int max_tries = 300;

// Distance of two robots that start.
double apart_of(const SolidBodies& solids) {
  return 2 * solids.robot_radius_m() + 0.001;
}

std::int64_t cell_of(double x, double y, int right, int up, double apart_m) {
  constexpr std::int64_t most_columns = 1 << 20;
  return (static_cast<std::int64_t>(std::floor(y / apart_m)) + up) * most_columns +
         static_cast<std::int64_t>(std::floor(x / apart_m)) + right;
}

bool is_inside(double x, double y, double width_m, double height_m, double radius_m) {
  return std::abs(x) <= width_m / 2 - radius_m + rounding_m && std::abs(y) <= height_m / 2 - radius_m + rounding_m;
}

}  // namespace

// A box, or, with an outer radius, what lies between two circles.
struct StartPlaces::Region {
  double x = 0, y = 0, half_width_m = 0, half_height_m = 0;
  double inner_m = 0, outer_m = -1;

  hal::Point drawn(hal::RandomStream& chance) const {
    if (outer_m < 0)
      return {x + chance.uniform(-half_width_m, half_width_m), y + chance.uniform(-half_height_m, half_height_m)};
    const double far = std::sqrt(chance.uniform(inner_m * inner_m, outer_m * outer_m)),
                 bearing = chance.uniform(-std::numbers::pi, std::numbers::pi);
    return {x + far * hal::fixed::cos(bearing), y + far * hal::fixed::sin(bearing)};
  }
  bool contains(double at_x, double at_y) const {
    const double far2 = (at_x - x) * (at_x - x) + (at_y - y) * (at_y - y);
    return outer_m < 0 || (far2 >= inner_m * inner_m && far2 <= outer_m * outer_m);
  }
};

StartPlaces::StartPlaces(double width_m, double height_m, const SolidBodies& solids, std::vector<hal::Pose> given)
    : sides_{width_m, height_m}, apart_m_(apart_of(solids)), solids_(solids), given_(std::move(given)) {}

StartPlaces::Region StartPlaces::region_of(const StartSettings& start) const {
  using Start = StartSettings::Start;
  const std::vector<double>& at = start.start_at;
  switch (start.start) {
    case Start::centre80:
      return {.half_width_m = 0.4 * sides_.width_m, .half_height_m = 0.4 * sides_.height_m};
    case Start::box:
      return {at[0], at[1], at[2] / 2, at[3] / 2};
    case Start::disc:
      return {at[0], at[1], at[2], at[2], 0, at[2]};
    case Start::ring:
      return {at[0], at[1], at[3], at[3], at[2], at[3]};
    default:
      return {.half_width_m = sides_.width_m / 2 - solids_.robot_radius_m(),
              .half_height_m = sides_.height_m / 2 - solids_.robot_radius_m()};
  }
}

bool StartPlaces::is_free(double x, double y) const {
  if (!is_inside(x, y, sides_.width_m, sides_.height_m, solids_.robot_radius_m())) return false;
  if (!solids_.empty() && solids_.clearance_m(x, y, apart_m_) < apart_m_ / 2) return false;
  const auto is_near = [&](const hal::Pose& other) {
    const double dx = other.x_m - x, dy = other.y_m - y;
    return dx * dx + dy * dy < apart_m_ * apart_m_;
  };
  if (std::ranges::any_of(given_, is_near)) return false;
  for (const int up : {-1, 0, 1})
    for (const int right : {-1, 0, 1}) {
      const auto cell = cells_.find(cell_of(x, y, right, up, apart_m_));
      if (cell == cells_.end()) continue;
      if (std::ranges::any_of(cell->second, [&](std::size_t other) { return is_near(poses_[other]); })) return false;
    }
  return true;
}

void StartPlaces::take(const hal::Pose& pose) {
  cells_[cell_of(pose.x_m, pose.y_m, 0, 0, apart_m_)].push_back(poses_.size());
  poses_.push_back(pose);
}

void StartPlaces::forget_behind(std::size_t first) {
  const std::vector<hal::Pose> stay(poses_.begin(), poses_.begin() + static_cast<std::ptrdiff_t>(first));
  poses_.clear();
  cells_.clear();
  for (const hal::Pose& pose : stay) take(pose);
}

void StartPlaces::draw(int robots, const Region& region, hal::RandomStream& chance) {
  for (int placed = 0; placed < robots; ++placed) {
    bool found = false;
    for (int k = 0; k < max_tries && !found; ++k) {
      const hal::Point at = region.drawn(chance);
      found = is_free(at.x_m, at.y_m);
      if (found) take({at.x_m, at.y_m, 0});
    }
    if (!found) return;
  }
}

// Grid places spread over the whole region.
std::vector<hal::Pose> StartPlaces::lattice(const Region& region) const {
  const int columns = static_cast<int>(2 * region.half_width_m / apart_m_) + 1,
            rows = static_cast<int>(2 * region.half_height_m / apart_m_) + 1;
  std::vector<hal::Pose> out;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const double x = region.x + (columns > 1 ? region.half_width_m * (2.0 * c / (columns - 1) - 1) : 0),
                   y = region.y + (rows > 1 ? region.half_height_m * (2.0 * r / (rows - 1) - 1) : 0);
      if (region.contains(x, y)) out.push_back({x, y, 0});
    }
  return out;
}

// A square grid round a place.
std::vector<hal::Pose> StartPlaces::grid(int robots, const std::vector<double>& at) {
  const int columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(robots)))),
            rows = (robots + columns - 1) / columns;
  std::vector<hal::Pose> out;
  for (int i = 0; i < robots; ++i)
    out.push_back(
        {at[0] + (i % columns - (columns - 1) / 2.0) * at[2], at[1] + (i / columns - (rows - 1) / 2.0) * at[2], 0});
  return out;
}

// So many of those that are free, in random order.
bool StartPlaces::choose(std::vector<hal::Pose> places, int robots, hal::RandomStream& chance) {
  std::erase_if(places, [this](const hal::Pose& place) { return !is_free(place.x_m, place.y_m); });
  if (static_cast<int>(places.size()) < robots) return false;
  for (std::size_t k = places.size(); k-- > 1;) std::swap(places[k], places[chance.below(k + 1)]);
  for (int i = 0; i < robots; ++i) {
    const hal::Pose& place = places[static_cast<std::size_t>(i)];
    if (!is_free(place.x_m, place.y_m)) return false;
    take(place);
  }
  return true;
}

bool StartPlaces::add(int robots, const StartSettings& start, hal::RandomStream chance) {
  const std::size_t first = poses_.size(), all = first + static_cast<std::size_t>(robots);
  for (const hal::Pose& pose : start.start_poses) take(pose);
  if (!start.start_poses.empty()) return true;
  if (start.start == StartSettings::Start::grid) {
    if (!choose(grid(robots, start.start_at), robots, chance)) return false;
  } else {
    const Region region = region_of(start);
    draw(robots, region, chance);
    if (poses_.size() < all) {
      forget_behind(first);
      if (!choose(lattice(region), robots, chance)) return false;
    }
  }
  for (std::size_t i = first; i < all; ++i) poses_[i].heading_rad = chance.uniform(-std::numbers::pi, std::numbers::pi);
  return true;
}

std::string error_with(const std::vector<hal::Pose>& places, double width_m, double height_m,
                       const SolidBodies& solids) {
  const double radius_m = solids.robot_radius_m(), apart_m = apart_of(solids);
  std::vector<double> x, y;
  for (const hal::Pose& place : places) {
    if (!is_inside(place.x_m, place.y_m, width_m, height_m, radius_m))
      return fmt::format("puts robot {} at {}, {}, not completely inside the walls", x.size(), place.x_m, place.y_m);
    if (solids.clearance_m(place.x_m, place.y_m, 1) < radius_m - rounding_m)
      return fmt::format("puts robot {} at {}, {}, where an obstacle or an object is", x.size(), place.x_m, place.y_m);
    x.push_back(place.x_m);
    y.push_back(place.y_m);
  }
  NeighbourGrid grid(width_m, height_m, apart_m, static_cast<int>(x.size()));
  grid.build(x, y);
  for (std::size_t i = 0; i < x.size(); ++i) {
    int other = -1;
    grid.visit_near(x[i], y[i], apart_m, [&](const NeighbourGrid::Member& member) {
      const auto j = static_cast<std::size_t>(member.number);
      if (j > i && hal::fixed::hypot(x[j] - x[i], y[j] - y[i]) < 2 * radius_m - rounding_m) other = member.number;
    });
    if (other >= 0) return fmt::format("puts robots {} and {} closer than {} m to each other", i, other, 2 * radius_m);
  }
  return {};
}

}  // namespace arkmesh::sim_ode
