// The only place where concrete arenas are named: one line each.
#pragma once

#include <memory>

#include "hal/arena.hpp"
#include "hal/config.hpp"
#include "scenarios/run_config.hpp"

namespace arkmesh::cli {

// The arena that arena.use asks for. Throws ConfigError.
std::unique_ptr<hal::Arena> make_arena(const hal::Section& root, const scenarios::RunConfig& run);

}  // namespace arkmesh::cli
