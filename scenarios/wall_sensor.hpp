// A virtual proximity sensor for walls: what a robot would see of its arena's edges if it had eight eyes in front.
// Pure arithmetic on a pose; any scenario may use it.
#pragma once

#include <cstdint>

#include "hal/types.hpp"

namespace arkmesh::scenarios {

// The front 180 degrees in eight equal sectors, one bit each, bit 7 the leftmost. A bit is set when a wall is nearer
// than `zone_m` (arena metres, from the robot's centre) and both edges of the sector point towards it. Walls are OR-ed.
std::uint8_t blocked_sectors(const hal::Pose& in_arena, double width_m, double height_m, double zone_m);

}  // namespace arkmesh::scenarios
