// What is in an arena beside robots: obstacles, which stay where they are, and objects, which robots can push. The keys
// of [[arena.obstacles]] and [[arena.objects]].
#pragma once

#include <string>
#include <vector>

#include "hal/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

struct Solids {
  std::vector<Obstacle> obstacles;
  std::vector<MovableObject> objects;
};

// Reads both lists of [arena]. Throws ConfigError.
Solids read_solids(const Section& arena);
// Their keys, for the table of all keys.
std::vector<KeyRow> solids_keys();

}  // namespace arkmesh::hal
