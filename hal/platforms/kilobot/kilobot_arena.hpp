// A table of real Kilobots as an arena: cameras see them, an overhead controller talks to them. Cannot wait: lab time
// is real time.
#pragma once

#include <memory>
#include <string>

#include "hal/arena.hpp"
#include "hal/config.hpp"
#include "hal/platforms/kilobot/robot_watch.hpp"
#include "hal/platforms/kilobot/wire.hpp"
#include "hal/wall_time.hpp"

namespace arkmesh::hal::kilobot {

// Reads the common [arena] keys (see arena_config.hpp; `pace` has no effect) and [arena.kilobot]: `port` (required: a
// device or tcp://host:port), `ids` (see robot_ids.hpp), `names_within_s` (120, 1..3600), `may_miss` (0: how many
// robots may then be missing), and those of read_overhead_settings. advance_to(0) is there when the overhead controller
// listens and every robot has been seen and named, and throws std::runtime_error with what is missing when that takes
// longer than names_within_s. Robots that may be missing are counted then as `robots.missing_at_start` and looked for
// on the way. Afterwards it never throws: a camera or a controller that is gone costs frames or messages, which are
// counted, until it is back. Destroying it before end() was true waits until it is. Counts `poses.lost.no_picture`,
// `poses.refused.unknown_robot`, `poses.refused.outside`, what OverheadController counts, and what `eyes` counts.
// Throws ConfigError, also for a device that cannot be opened.
std::unique_ptr<Arena> make_kilobot_arena(const Section& arena, const std::string& lab,
                                          std::unique_ptr<RobotWatch> eyes);

// The same with a wire of the caller's instead of `port`, and another time than the machine's; `wall` outlives the
// arena.
std::unique_ptr<Arena> make_kilobot_arena(const Section& arena, const std::string& lab,
                                          std::unique_ptr<RobotWatch> eyes, std::unique_ptr<Wire> wire,
                                          WallTime& wall = machine_time());

}  // namespace arkmesh::hal::kilobot
