// Reads the common [arena] keys and checks that the robots have room.
#include "hal/arena_config.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

namespace arkmesh::hal {

double read_side(const Section& arena, std::string_view key) {
  const double side_m = arena.number(key, 1.0);
  if (!(side_m > 0 && side_m <= 100)) arena.refuse(key, "must be above 0 and at most 100 metres");
  return side_m;
}

ArenaConfig read_arena_config(const Section& arena, double body_radius_m) {
  ArenaConfig out;
  out.width_m = read_side(arena, "width_m");
  out.height_m = read_side(arena, "height_m");
  out.robots = static_cast<int>(arena.integer("robots", 1, 0, 100'000));

  // a square grid must hold them
  const double cell_m = 2 * body_radius_m + 0.001;
  const auto columns = static_cast<std::int64_t>(out.width_m / cell_m),
             rows = static_cast<std::int64_t>(out.height_m / cell_m);
  if (out.robots > columns * rows)
    arena.refuse("robots",
                 fmt::format("too many for an arena of {} m x {} m, which holds {}; make it larger or take fewer",
                             out.width_m, out.height_m, columns * rows));

  const double period_s = arena.number("frame_period_s", 0.1, {0, 60});
  const double period_us = std::round(period_s * 1e6);
  if (period_us < 1 || std::abs(period_s * 1e6 - period_us) > 1e-6)
    arena.refuse("frame_period_s", "must be a whole number of microseconds, at least 0.000001");
  out.frame_period = LabTime{static_cast<std::int64_t>(period_us)};

  out.pace = arena.number("pace", 0.0);
  if (out.pace != 0 && out.pace != 1) arena.refuse("pace", "must be 0 (as fast as asked) or 1 (real time)");
  return out;
}

}  // namespace arkmesh::hal
