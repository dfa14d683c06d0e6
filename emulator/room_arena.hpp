// A virtual room as an arena: the physical arena, unchanged, at cameras and an overhead controller that are computed in
// this process, in the room's own time. Runs as fast as it can be computed, at most 20 ms of the room's time a call;
// equal seeds give equal runs.
#pragma once

#include <memory>
#include <string>

#include "emulator/room.hpp"
#include "hal/arena.hpp"
#include "hal/arena_row.hpp"
#include "hal/config.hpp"
#include "testbed/table_watch.hpp"

namespace arkmesh::emulator {

// Reads [arena.room]: `file` (required: a room's file, see `arkmesh room`), and [arena.kilobot] as the physical arena
// does; of its cameras only the calibration counts, camera k is the room's camera k. The room's seed becomes `seed`.
// Throws ConfigError.
std::unique_ptr<hal::Arena> make_room_arena(const hal::Section& arena, const std::string& lab, std::uint64_t seed,
                                            testbed::Onlooker onlooker);
hal::ArenaRow room_arena_row();

// The room of an arena that make_room_arena made, for tests and measurements that need its truth or its mishaps.
emulator::Room& room_of(hal::Arena& arena);

}  // namespace arkmesh::emulator
