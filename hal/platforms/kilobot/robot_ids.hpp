// Which Kilobots are in the arena: ids are written on them and need not begin at 0.
#pragma once

#include <vector>

#include "hal/config/config.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal::kilobot {

// arena.kilobot.ids, a list such as ["0-11", "40"]; without it 0 to arena.robots - 1. Ascending. Throws ConfigError:
// not as many as arena.robots, an id twice, or one that the layout cannot name.
std::vector<RobotId> read_robot_ids(const Section& arena, const WordLayout& layout);

}  // namespace arkmesh::hal::kilobot
