// The keys of [arena] that every simulated arena shares.
#pragma once

#include "hal/arena.hpp"
#include "hal/config.hpp"

namespace arkmesh::hal {

struct ArenaConfig {
  double width_m = 1;             // arena.width_m, > 0, at most 100
  double height_m = 1;            // arena.height_m
  int robots = 1;                 // arena.robots, 0..100000; ids 0..robots-1
  LabTime frame_period{100'000};  // arena.frame_period_s, whole microseconds
  double pace = 0;                // arena.pace: 0 as fast as asked, can wait; 1 keeps real time, cannot wait
};

// The side of an arena in metres, `width_m` or `height_m`. Throws ConfigError.
double read_side(const Section& arena, std::string_view key);

// Throws ConfigError: negative size, frame period of zero, more robots of that radius than fit in the arena (a square
// grid of one diameter plus 1 mm is what must hold them).
ArenaConfig read_arena_config(const Section& arena, double body_radius_m);

}  // namespace arkmesh::hal
