// An arena in which nothing moves and nobody listens: the do-nothing implementation of Arena. Its robots stand on a
// grid.
#pragma once

#include <memory>

#include "hal/arena.hpp"
#include "hal/arena_row.hpp"
#include "hal/config.hpp"

namespace arkmesh::hal {

// Reads the common [arena] keys (see arena_config.hpp).
std::unique_ptr<Arena> make_null_arena(const Section& arena, const std::string& lab);
ArenaRow null_arena_row();

}  // namespace arkmesh::hal
