// What an arena's file says of its robots: what they are, their groups, ids and places at the start. All throw
// ConfigError.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/arenas/arena_config.hpp"
#include "hal/config/config.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "sim_ode/settings.hpp"
#include "sim_ode/solid_bodies.hpp"

namespace arkmesh::sim_ode {

// What robots are, and how words lie in what their programs hear.
hal::RobotKind robots_of(Robot robot, const hal::kilobot::WordLayout& layout);

hal::ArenaInfo info_of(const hal::ArenaConfig& config, const Settings& settings, const hal::kilobot::WordLayout& layout,
                       const hal::Solids& solids, const std::string& lab);

// All robots of the arena: its groups, and last those that are in none.
std::vector<GroupSettings> groups_of(const hal::Section& ode, const Settings& settings, int robots);

// Gives each robot its id, if any is stated, and puts groups into the order of their ids. `named`: kilo_uid by robot,
// which must be empty then.
void number_robots(const hal::Section& ode, Settings& settings, std::vector<GroupSettings>& groups,
                   std::vector<std::uint16_t>& named);

// Where they start.
std::vector<hal::Pose> start_of(const hal::ArenaConfig& config, const std::vector<GroupSettings>& groups,
                                const hal::Section& ode, const SolidBodies& furniture, const std::string& lab,
                                std::uint64_t seed);

}  // namespace arkmesh::sim_ode
