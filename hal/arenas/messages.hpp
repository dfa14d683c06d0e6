// Lab values <-> LCM messages. The only place where the two meet, but for what scenarios draw (drawing_message).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "arkmesh/arena_info_t.hpp"
#include "arkmesh/counter_t.hpp"
#include "arkmesh/fleet_command_t.hpp"
#include "arkmesh/from_robots_t.hpp"
#include "arkmesh/not_standing_t.hpp"
#include "arkmesh/pose_frame_t.hpp"
#include "arkmesh/to_robots_t.hpp"
#include "hal/arenas/arena.hpp"
#include "hal/bus/channel_names.hpp"
#include "hal/counters.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

// One message, or several parts with at most 1000 robots each.
std::vector<pose_frame_t> to_messages(const PoseFrame& frame);
PoseFrame from_message(const pose_frame_t& part);
to_robots_t to_message(std::span<const ToRobot> messages, LabTime stamp, std::uint32_t frame);
std::vector<ToRobot> from_message(const to_robots_t& message);
from_robots_t to_message(std::span<const FromRobot> messages, LabTime stamp);
fleet_command_t to_message(const FleetCommand& command, LabTime stamp);
// Nothing when the command is none of ours.
std::optional<FleetCommand> from_message(const fleet_command_t& message);
not_standing_t to_message(const NotStanding& robot);
// A reason that is none of ours counts as not in sight.
NotStanding from_message(const not_standing_t& robot);
arena_info_t to_message(const ArenaInfo& info);
// Adds the message's obstacles and objects; false when it contradicts itself.
bool read_solids(const arena_info_t& message, ArenaInfo& info);
std::vector<counter_t> to_message(const Counters& counters);

}  // namespace arkmesh::hal
