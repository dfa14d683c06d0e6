// The poses of a recorded LCM log as an arena that can wait: same frame period, same robots. Offers are accepted and
// counted as not sent.
#pragma once

#include <memory>

#include "hal/arena.hpp"
#include "hal/arena_row.hpp"
#include "hal/config.hpp"

namespace arkmesh::hal {

// Key [arena.replay] log. `run_length` beyond the log's last frame is a ConfigError, as is a log without poses.
// Width and height come from the log's `arena` message.
std::unique_ptr<Arena> make_log_arena(const Section& arena, const std::string& lab, LabTime run_length);
ArenaRow log_arena_row();

}  // namespace arkmesh::hal
