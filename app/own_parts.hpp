// For a lab whose arena and scenario are in none of the tables: whoever makes it brings them. The rest of the lab is
// made as ever.
#pragma once

#include <memory>

#include "hal/arenas/arena.hpp"
#include "hal/config/config.hpp"
#include "hal/event_loop.hpp"
#include "lab/run_config.hpp"
#include "lab/scenario.hpp"

namespace arkmesh::app {

class OwnParts {
 public:
  struct Made {
    std::unique_ptr<hal::Arena> arena;
    std::unique_ptr<lab::Scenario> scenario;
  };
  virtual ~OwnParts() = default;
  // Reads [arena] and [scenario.NAME], and leaves alone what it does not need of them. `loop` outlives what it makes.
  // Throws ConfigError.
  virtual Made make(const hal::Config& config, const lab::RunConfig& run, hal::EventLoop& loop) = 0;
};

}  // namespace arkmesh::app
