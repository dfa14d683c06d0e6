// How many robots a lab can have: as many as its platform can address, and as its messages to other labs can tell of.
#pragma once

#include <map>
#include <string>

#include "app/scenarios.hpp"
#include "hal/arenas/arena.hpp"
#include "hal/config/config.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::app {

// Throws ConfigError with the number that fits. Robots that cannot be addressed are worth a warning only when
// `scenario` addresses none. `settings` is what all labs must have alike: messages carry it, too.
void check_robot_limits(const hal::Section& root, const lab::RunConfig& run, const CatalogueEntry& scenario,
                        const hal::ArenaInfo& arena, const std::map<std::string, std::string, std::less<>>& settings);

}  // namespace arkmesh::app
