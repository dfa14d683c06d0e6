// Robots sorted into cells as large as the range: neighbours are in the nine cells around.
#include "scenarios/kit/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "scenarios/kit/bearing.hpp"

namespace arkmesh::scenarios::kit {
namespace {

bool shows(const Seen& robot, LedSet leds) {
  return (leds >> static_cast<unsigned>(robot.led) & 1U) != 0;
}

}  // namespace

void each_near(std::span<const Seen> robots, std::span<const Seen> all, double range_m,
               const std::function<void(std::size_t robot, std::size_t other)>& visit) {
  if (!(range_m > 0) || !std::isfinite(range_m))
    throw std::invalid_argument("the range of neighbours must be a positive number");
  using Cell = std::pair<std::int64_t, std::int64_t>;
  const auto cell_of = [range_m](const hal::Point& p) {
    const auto along = [range_m](double at) {
      return static_cast<std::int64_t>(std::clamp(std::floor(at / range_m), -1e15, 1e15));
    };
    return Cell{along(p.x_m), along(p.y_m)};
  };
  std::vector<std::pair<Cell, std::size_t>> sorted;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (std::isfinite(all[i].place.x_m) && std::isfinite(all[i].place.y_m))
      sorted.emplace_back(cell_of(all[i].place), i);
  std::ranges::sort(sorted);
  for (std::size_t r = 0; r < robots.size(); ++r) {
    const hal::Point& here = robots[r].place;
    if (!std::isfinite(here.x_m) || !std::isfinite(here.y_m)) continue;
    const auto [column, row] = cell_of(here);
    for (std::int64_t c = column - 1; c <= column + 1; ++c) {
      // three cells of a column lie one behind the other
      auto at = std::ranges::lower_bound(sorted, std::pair(Cell{c, row - 1}, std::size_t{0}));
      for (; at != sorted.end() && at->first <= Cell{c, row + 1}; ++at) {
        if (distance2_m2(all[at->second].place, here) <= range_m * range_m) visit(r, at->second);
      }
    }
  }
}

std::vector<int> neighbours(std::span<const Seen> robots, std::span<const Seen> all, double range_m, LedSet leds) {
  std::vector<int> counts(robots.size(), 0);
  each_near(robots, all, range_m,
            [&](std::size_t robot, std::size_t other) { counts[robot] += other != robot && shows(all[other], leds); });
  return counts;
}

double share(std::span<const Seen> robots, LedSet leds) {
  if (robots.empty()) return 0;
  const auto n = std::ranges::count_if(robots, [leds](const Seen& robot) { return shows(robot, leds); });
  return static_cast<double>(n) / static_cast<double>(robots.size());
}

}  // namespace arkmesh::scenarios::kit
