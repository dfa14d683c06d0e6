// The poses of a recorded LCM log as an arena that can wait: same frame period, same robots. Offers are accepted and
// counted as not sent.
#pragma once

#include <memory>

#include "hal/arenas/arena.hpp"
#include "hal/arenas/arena_row.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::hal {

// Key [arena.replay] log. `run_length` beyond the log's last frame is a ConfigError, as is a log without poses.
// Width, height, how large robots are and what can be said come from the log's `arena` message; `robot` is what no log
// tells, or an old one does not.
std::unique_ptr<Arena> make_log_arena(const Section& arena, const std::string& lab, const RobotKind& robot,
                                      LabTime run_length);
ArenaRow log_arena_row();

}  // namespace arkmesh::hal
