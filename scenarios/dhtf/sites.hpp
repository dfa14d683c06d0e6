// Where the sites are and what tasks they hold: drawn once, by the owner of the shared world.
#pragma once

#include <vector>

#include "hal/arenas/projection.hpp"
#include "hal/random.hpp"
#include "scenarios/dhtf/settings.hpp"

namespace arkmesh::scenarios::dhtf {

// One of the 4x4 cells of the owner's arena: 0 is the north-west corner, numbered row by row, west to east.
// The centre of the cell in the shared frame.
hal::Pose cell_in_shared(int cell, double arena_width_m, double arena_height_m, const hal::Projection& owner);

// `settings.sites` cells, ascending.
std::vector<int> draw_cells(const Settings& settings, hal::RandomStream& random);
// For one lab: 1 where its task is hard, 0 where it is easy.
std::vector<int> draw_hard(const Settings& settings, hal::RandomStream& random);

// Seconds a robot waits at a site that is hard in `hard` of `labs` labs.
int timeout_s(const Settings& settings, std::size_t hard, std::size_t labs);

}  // namespace arkmesh::scenarios::dhtf
