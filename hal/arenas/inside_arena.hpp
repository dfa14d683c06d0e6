// What cameras may report of an arena's robots.
#pragma once

#include "hal/arenas/arena.hpp"
#include "hal/counters.hpp"

namespace arkmesh::hal {

// Takes robots that are none of the arena's, or farther out than a body's radius, off a frame, and counts them as
// `poses.refused.unknown_robot` and `.outside`. A robot at the wall, which may be measured a little beyond it, is put
// back inside.
void keep_inside(PoseFrame& frame, const ArenaInfo& info, Counters& counters);

}  // namespace arkmesh::hal
