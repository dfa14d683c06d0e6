#include "scenarios/dhtf/sites.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace arkmesh::scenarios::dhtf {
namespace {

// The first `n` of a shuffled `pool`.
std::vector<int> draw(std::vector<int> pool, std::size_t n, hal::RandomStream& random) {
  for (std::size_t i = 0; i < n; ++i) std::swap(pool[i], pool[i + random.below(pool.size() - i)]);
  pool.resize(n);
  return pool;
}

}  // namespace

hal::Pose cell_in_shared(int cell, double arena_width_m, double arena_height_m, const hal::Projection& owner) {
  const double column = cell % 4, row = cell / 4;
  return owner.to_shared({.x_m = (column - 1.5) / 4 * arena_width_m, .y_m = (1.5 - row) / 4 * arena_height_m});
}

std::vector<int> draw_cells(const Settings& settings, hal::RandomStream& random) {
  std::vector<int> cells;
  for (int cell = 0; cell < 16; ++cell) {
    const bool corner = cell == 0 || cell == 3 || cell == 12 || cell == 15;
    if (settings.corners || !corner) cells.push_back(cell);
  }
  cells = draw(std::move(cells), static_cast<std::size_t>(settings.sites), random);
  std::sort(cells.begin(), cells.end());
  return cells;
}

std::vector<int> draw_hard(const Settings& settings, hal::RandomStream& random) {
  const auto sites = static_cast<std::size_t>(settings.sites);
  std::vector<int> hard(sites, settings.types == Types::hard ? 1 : 0);
  if (settings.types == Types::random)
    for (int& h : hard) h = static_cast<int>(random.below(2));
  if (settings.types == Types::half) {
    std::vector<int> all(sites);
    std::iota(all.begin(), all.end(), 0);
    for (int site : draw(std::move(all), sites / 2, random)) hard[static_cast<std::size_t>(site)] = 1;
  }
  return hard;
}

int timeout_s(const Settings& settings, std::size_t hard, std::size_t labs) {
  return settings.timeouts_s[hard == 0 ? 0 : hard < labs ? 1 : 2];
}

}  // namespace arkmesh::scenarios::dhtf
