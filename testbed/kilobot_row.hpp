// arena.use = "kilobot": the row of a testbed of real Kilobots.
#pragma once

#include "hal/arenas/arena_row.hpp"

namespace arkmesh::testbed {

hal::ArenaRow kilobot_arena_row();

}  // namespace arkmesh::testbed
