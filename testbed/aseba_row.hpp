// arena.use = "aseba": robots that speak Aseba and carry markers, under cameras.
#pragma once

#include <vector>

#include "hal/arenas/arena_row.hpp"
#include "hal/finding.hpp"

namespace arkmesh::testbed {

hal::ArenaRow aseba_arena_row();

// What `arkmesh doctor` says of the hardware that a lab's file names: each robot's node, its cameras, and how fast
// robots may move for their exposure. Takes some seconds. Throws ConfigError.
std::vector<hal::Finding> find_nodes(const hal::Section& arena);

}  // namespace arkmesh::testbed
