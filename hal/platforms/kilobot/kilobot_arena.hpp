// A testbed of real Kilobots as an arena: cameras see them, an overhead controller talks to them. Cannot wait: lab time
// is real time.
#pragma once

#include <memory>
#include <string>

#include "hal/arenas/arena.hpp"
#include "hal/platforms/kilobot/arena_settings.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"
#include "hal/platforms/kilobot/robot_monitor.hpp"
#include "hal/platforms/kilobot/stand_guard.hpp"
#include "hal/time/wall_time.hpp"

namespace arkmesh::hal::kilobot {

// The device named: one that is not there now is a mistake in the file or in the arena, later it is a fault that heals.
// `lab` is named to others who want it. Throws PortError.
std::unique_ptr<ByteStream> open_byte_stream(const std::string& port, const std::string& lab,
                                             std::shared_ptr<StandGuard> guard = nullptr);

// advance_to(0) is there when the overhead controller listens and every robot has been seen and named, and throws
// std::runtime_error with what is missing when that takes longer than names_within. Robots that may be missing are
// counted then as `robots.missing_at_start` and looked for on the way. Afterwards it never throws: a camera or a
// controller that is gone costs frames or messages, which are counted, until it is back. Destroying it before end() was
// true waits until it is. Counts `poses.lost.no_picture`, `poses.refused.unknown_robot`, `poses.refused.outside`, what
// OverheadController counts, and what `eyes` counts. `wall`, when it is not the machine's, outlives the arena.
std::unique_ptr<Arena> make_kilobot_arena(ArenaSettings settings, std::unique_ptr<RobotMonitor> eyes,
                                          std::unique_ptr<ByteStream> stream,
                                          std::shared_ptr<StandGuard> guard = nullptr, WallTime& wall = machine_time());

}  // namespace arkmesh::hal::kilobot
