#include "scenarios/kit/floor_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace arkmesh::scenarios::kit {
namespace {

constexpr int most_tiles_a_side = 1000;

std::size_t tiles_of(const FloorMap::Size& size) {
  if (size.columns < 1 || size.rows < 1 || size.columns > most_tiles_a_side || size.rows > most_tiles_a_side)
    throw std::invalid_argument(fmt::format("a floor of {} x {} tiles is not possible; give 1 to {} on each side",
                                            size.columns, size.rows, most_tiles_a_side));
  if (!(size.width_m > 0) || !(size.height_m > 0) || !std::isfinite(size.width_m) || !std::isfinite(size.height_m))
    throw std::invalid_argument("a floor needs a width and a height");
  return static_cast<std::size_t>(size.columns) * static_cast<std::size_t>(size.rows);
}

// Means of all tiles within `patch` in both directions, the floor's edge being the end.
std::vector<double> smoothed(const std::vector<double>& drawn, int columns, int rows, int patch) {
  const auto along = [&](const std::vector<double>& from, bool across) {
    std::vector<double> out(from.size());
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) {
        const int at = across ? row : column, end = across ? rows : columns;
        double sum = 0;
        const int low = std::max(at - patch, 0), high = std::min(at + patch, end - 1);
        for (int k = low; k <= high; ++k)
          sum += from[static_cast<std::size_t>(across ? k * columns + column : row * columns + k)];
        out[static_cast<std::size_t>(row * columns + column)] = sum / (high - low + 1);
      }
    return out;
  };
  return along(along(drawn, false), true);
}

}  // namespace

FloorMap::FloorMap(const Size& size, std::vector<std::uint8_t> tiles) : size_(size), tiles_(std::move(tiles)) {
  if (const std::size_t wanted = tiles_of(size); tiles_.size() != wanted)
    throw std::invalid_argument(
        fmt::format("a floor of {} x {} tiles has {} levels, not {}", size.columns, size.rows, wanted, tiles_.size()));
}

// Tiles are ranked by what was drawn for them, so that shares are exact whatever the patches.
FloorMap FloorMap::drawn(const Size& size, const std::vector<double>& shares, int patch, hal::RandomStream& random) {
  const std::size_t n = tiles_of(size);
  const double all = std::accumulate(shares.begin(), shares.end(), 0.0);
  if (shares.empty() || shares.size() > 256 || !(all > 0) || !std::isfinite(all) ||
      std::ranges::any_of(shares, [](double s) { return s < 0; }))
    throw std::invalid_argument("the levels of a floor need shares: 1 to 256 numbers of 0 or more, not all 0");
  if (patch < 0 || patch > most_tiles_a_side)
    throw std::invalid_argument(
        fmt::format("patches of {} tiles are not possible; give 0 to {}", patch, most_tiles_a_side));
  std::vector<double> drawn(n);
  for (double& d : drawn) d = random.uniform();
  if (patch > 0) drawn = smoothed(drawn, size.columns, size.rows, patch);
  std::vector<std::size_t> ranked(n);
  std::iota(ranked.begin(), ranked.end(), std::size_t{0});
  std::ranges::stable_sort(ranked, {}, [&](std::size_t tile) { return drawn[tile]; });
  std::vector<std::uint8_t> tiles(n);
  double until = 0;
  std::size_t at = 0;
  for (std::size_t level = 0; level < shares.size(); ++level) {
    until += shares[level] / all * static_cast<double>(n);
    const std::size_t end = level + 1 == shares.size() ? n : std::min(n, static_cast<std::size_t>(std::llround(until)));
    for (; at < end; ++at) tiles[ranked[at]] = static_cast<std::uint8_t>(level);
  }
  return {size, std::move(tiles)};
}

std::uint8_t FloorMap::at(const hal::Point& place) const {
  const auto along = [](double at_m, double side_m, int n) {
    const double tile = std::floor((at_m / side_m + 0.5) * n);
    return tile > 0 ? std::min(static_cast<int>(std::min(tile, 1e6)), n - 1) : 0;  // also not-a-number
  };
  const int column = along(place.x_m, size_.width_m, size_.columns), row = along(place.y_m, size_.height_m, size_.rows);
  return tiles_[static_cast<std::size_t>(row * size_.columns + column)];
}

void FloorMap::draw(lab::Lab& lab, const hal::Projection& arena, std::uint8_t full) const {
  const double cell_m = size_.width_m / size_.columns;
  if (full == 0 || std::abs(cell_m - size_.height_m / size_.rows) > 1e-9) return;
  hal::Raster raster{.corner = arena.to_arena({-size_.width_m / 2, -size_.height_m / 2, 0}),
                     .cell_m = cell_m / arena.scale,
                     .columns = size_.columns,
                     .colour = hal::Colour::note};
  for (const std::uint8_t level : tiles_)
    raster.cells.push_back(static_cast<std::uint8_t>(std::min(255, level * 255 / full)));
  lab.draw(std::move(raster));
}

}  // namespace arkmesh::scenarios::kit
