// The keys of [arena] that every simulated arena shares.
#pragma once

#include "hal/arenas/arena.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::hal {

struct ArenaSides {
  double width_m = 1, height_m = 1;  // along x, along y

  void fields(const Section& arena);
};

struct ArenaConfig : ArenaSides {
  int robots = 1;                 // ids 0..robots-1
  LabTime frame_period{100'000};  // whole microseconds
  double pace = 0;                // 0 as fast as asked, can wait; 1 keeps real time, cannot wait

  void fields(const Section& arena);
};

// Throws ConfigError, also for more robots of that radius than fit in the arena (a square grid of one diameter plus
// 1 mm is what must hold them).
ArenaConfig read_arena_config(const Section& arena, double body_radius_m);

}  // namespace arkmesh::hal
