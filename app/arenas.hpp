// The only place where concrete arenas are named: one line each.
#pragma once

#include <filesystem>
#include <memory>

#include "hal/arena.hpp"
#include "hal/bus.hpp"
#include "hal/config.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::app {

// The arena that arena.use asks for. An arena with cameras draws what it hears on `bus` over their pictures and keeps
// videos in `directory`; the bus outlives the arena. Throws ConfigError.
std::unique_ptr<hal::Arena> make_arena(const hal::Section& root, const lab::RunConfig& run, hal::Bus& bus,
                                       const std::filesystem::path& directory);

}  // namespace arkmesh::app
