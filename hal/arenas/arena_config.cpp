// Reads the common [arena] keys and checks that the robots have room.
#include "hal/arenas/arena_config.hpp"

#include <fmt/format.h>

#include <cstdint>

namespace arkmesh::hal {

void ArenaSides::fields(const Section& arena) {
  arena.field("width_m", width_m, {{0.001, 100}, "m", "along x"});
  arena.field("height_m", height_m, {{0.001, 100}, "m", "along y"});
}

void ArenaConfig::fields(const Section& arena) {
  ArenaSides::fields(arena);
  arena.field("robots", robots, {{0, 100'000}, "", "number of robots; simulated ones have ids from 0"});
  arena.field("frame_period_s", frame_period, {{1e-6, 60}, "s", "time between two pose frames"});
  arena.field("pace", pace, {{0, 1}, "", "0: as fast as asked, can wait; 1: real time, cannot wait"});
}

ArenaConfig read_arena_config(const Section& arena, double body_radius_m) {
  const auto out = arena.read<ArenaConfig>();
  if (out.pace != 0 && out.pace != 1) arena.refuse("pace", "must be 0 (as fast as asked) or 1 (real time)");
  const double cell_m = 2 * body_radius_m + 0.001;
  const auto columns = static_cast<std::int64_t>(out.width_m / cell_m),
             rows = static_cast<std::int64_t>(out.height_m / cell_m);
  if (out.robots > columns * rows)
    arena.refuse("robots",
                 fmt::format("too many for an arena of {} m x {} m, which holds {}; make it larger or use fewer",
                             out.width_m, out.height_m, columns * rows));
  return out;
}

}  // namespace arkmesh::hal
