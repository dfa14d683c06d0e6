// An arena in which nothing moves and nobody listens: the do-nothing implementation of Arena. Its robots stand on a
// grid.
#pragma once

#include <memory>

#include "hal/arenas/arena.hpp"
#include "hal/arenas/arena_row.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::hal {

// Reads the common [arena] keys (see arena_config.hpp). `robot`: what its robots would be.
std::unique_ptr<Arena> make_null_arena(const Section& arena, const std::string& lab, const RobotKind& robot);
ArenaRow null_arena_row();

}  // namespace arkmesh::hal
