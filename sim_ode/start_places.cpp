// One after the other at random; a crowd too dense for that stands on a square grid, each on a random place of it.
#include "sim_ode/start_places.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>
#include <utility>

#include "hal/fixed_math.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "hal/random.hpp"
#include "sim_ode/neighbour_grid.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double apart_m = 2 * hal::kilobot::body_radius_m + 0.001;
constexpr int max_tries = 300;

}  // namespace

std::vector<hal::Pose> start_places(int robots, double half_width_m, double half_height_m, const std::string& lab,
                                    std::uint64_t seed, const SolidBodies& solids) {
  hal::RandomStream chance(seed, lab + "/ode/start");
  std::vector<hal::Pose> out;
  // cells of one distance: whoever is too near lies in a neighbouring cell. Only cells with somebody in them are kept
  const int columns = static_cast<int>(2 * half_width_m / apart_m) + 1,
            rows = static_cast<int>(2 * half_height_m / apart_m) + 1;
  std::unordered_map<std::int64_t, std::vector<int>> cells;
  const auto number = [columns](int column, int row) { return static_cast<std::int64_t>(row) * columns + column; };
  const auto is_clear = [&](double x, double y) {
    return solids.empty() || solids.clearance_m(x, y, apart_m) >= apart_m / 2;
  };
  const auto is_free = [&](double x, double y, int column, int row) {
    if (!is_clear(x, y)) return false;
    for (int r = std::max(0, row - 1); r <= std::min(rows - 1, row + 1); ++r)
      for (int c = std::max(0, column - 1); c <= std::min(columns - 1, column + 1); ++c) {
        const auto cell = cells.find(number(c, r));
        if (cell == cells.end()) continue;
        for (int other : cell->second) {
          const double dx = out[static_cast<std::size_t>(other)].x_m - x,
                       dy = out[static_cast<std::size_t>(other)].y_m - y;
          if (dx * dx + dy * dy < apart_m * apart_m) return false;
        }
      }
    return true;
  };
  for (bool found = true; found && static_cast<int>(out.size()) < robots;) {
    found = false;
    for (int k = 0; k < max_tries && !found; ++k) {
      const double x = chance.uniform(-half_width_m, half_width_m), y = chance.uniform(-half_height_m, half_height_m);
      const int column = static_cast<int>((x + half_width_m) / apart_m),
                row = static_cast<int>((y + half_height_m) / apart_m);
      if (!is_free(x, y, column, row)) continue;
      cells[number(column, row)].push_back(static_cast<int>(out.size()));
      out.push_back({x, y, 0});
      found = true;
    }
  }
  if (static_cast<int>(out.size()) < robots) {
    // grid places spread over the whole region, the first `robots` of a random order
    if (static_cast<std::int64_t>(columns) * rows < robots) return {};
    out.clear();
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; ++c) {
        const hal::Pose place{columns > 1 ? half_width_m * (2.0 * c / (columns - 1) - 1) : 0,
                              rows > 1 ? half_height_m * (2.0 * r / (rows - 1) - 1) : 0, 0};
        if (is_clear(place.x_m, place.y_m)) out.push_back(place);
      }
    if (static_cast<int>(out.size()) < robots) return {};
    for (std::size_t k = out.size(); k-- > 1;) std::swap(out[k], out[chance.below(k + 1)]);
    out.resize(static_cast<std::size_t>(robots));
  }
  for (hal::Pose& pose : out) pose.heading_rad = chance.uniform(-std::numbers::pi, std::numbers::pi);
  return out;
}

std::string error_with(const std::vector<hal::Pose>& places, double width_m, double height_m,
                       const SolidBodies& solids) {
  constexpr double allowed_m = 1e-6;  // of rounding
  std::vector<double> x, y;
  for (const hal::Pose& place : places) {
    if (std::abs(place.x_m) > width_m / 2 - hal::kilobot::body_radius_m + allowed_m ||
        std::abs(place.y_m) > height_m / 2 - hal::kilobot::body_radius_m + allowed_m)
      return fmt::format("puts robot {} at {}, {}, not wholly inside the walls", x.size(), place.x_m, place.y_m);
    if (solids.clearance_m(place.x_m, place.y_m, 1) < hal::kilobot::body_radius_m - allowed_m)
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
      if (j > i && hal::fixed::hypot(x[j] - x[i], y[j] - y[i]) < 2 * hal::kilobot::body_radius_m - allowed_m)
        other = member.number;
    });
    if (other >= 0)
      return fmt::format("puts robots {} and {} nearer than {} m to each other", i, other,
                         2 * hal::kilobot::body_radius_m);
  }
  return {};
}

}  // namespace arkmesh::sim_ode
