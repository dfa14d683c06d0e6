// A testbed with rovers as an arena: a camera sees them, a base station talks with them. Cannot wait: lab time is real
// time.
#pragma once

#include <memory>
#include <string>

#include "hal/arenas/arena.hpp"
#include "hal/arenas/arena_row.hpp"
#include "hal/config/config.hpp"
#include "tests/examples/rover/devices.hpp"

namespace arkmesh::examples::rover {

inline constexpr double body_radius_m = 0.03, speed_m_s = 0.05;

// Reads the common [arena] keys (see hal/arenas/arena_config.hpp; `pace` has no effect) and arena.rover.names_within_s
// (10, 0.1..3600). advance_to(0) is there when every rover has shown its light, and throws std::runtime_error when that
// takes longer. Each rover answers what it is told with the same kind and value. Destroying the arena before end() was
// true waits until it is. Counts `from_robots.refused.unknown_robot`, `from_robots.damaged_bytes` and, for each rover
// and frame, `poses.lost.robot`. `wall` outlives the arena. Throws ConfigError.
std::unique_ptr<hal::Arena> make_rover_arena(const hal::Section& arena, const std::string& lab,
                                             std::shared_ptr<ByteStream> stream, std::shared_ptr<SpotCamera> camera,
                                             hal::WallTime& wall = hal::machine_time());

// arena.use = "rover": simulated rovers, because nobody has built one; a row of real ones opens its devices here. Reads
// arena.rover.damage, too: the share of bytes that are changed on their way (0, 0..1).
hal::ArenaRow rover_arena_row();

}  // namespace arkmesh::examples::rover
