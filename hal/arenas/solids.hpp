// What is in an arena beside robots: obstacles, which stay where they are, and objects, which robots can push. The keys
// of [[arena.obstacles]] and [[arena.objects]], and the arena's shape.
#pragma once

#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

struct Solids {
  std::vector<Obstacle> obstacles;  // the last ones are the rim, if there is one: a wall behind each of its sides
  std::vector<Point> rim;           // corners of an arena that is no rectangle, counter-clockwise; robots stay inside
  std::vector<MovableObject> objects;
};

// Reads both lists of [arena]. Throws ConfigError.
Solids read_solids(const Section& arena);
// Their keys, for the table of all keys.
std::vector<KeyRow> solids_keys();

}  // namespace arkmesh::hal
