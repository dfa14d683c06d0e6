// Keys of [arena.ode] about light and messages that go wrong with place, robot and time. Their defaults are ideal: no
// effect at all. docs/model-truth.md proposes values, with sources.
#pragma once

#include <limits>

#include "hal/config/config.hpp"
#include "sim_ode/host/turns/distance_readings.hpp"

namespace arkmesh::sim_ode {

struct AirSettings {
  // overhead controller
  double overhead_loss_edge = std::numeric_limits<double>::quiet_NaN();  // as overhead_loss, in the arena's corners
  double overhead_distance_m = assumed_overhead_m;                       // that robots measure to the controller
  // robot infrared
  double ir_noise_per_m = 0;     // what distance adds to ir_noise_m
  double ir_flat_m = 0;          // measured distances go no farther; 0: they do
  double ir_reading_spread = 0;  // s.d. between pairs of a factor on measured distances

  void fields(const hal::Section& ode) {
    ode.field("overhead_loss_edge", overhead_loss_edge,
              {.range = {0, 1}, .help = "overhead_loss in the arena's corners", .default_is = "overhead_loss"});
    ode.field(
        "overhead_distance_m", overhead_distance_m,
        {{0, assumed_overhead_m}, "m", "distance that robots measure to the overhead controller; assumed (ARGoS: 0)"});
    ode.field("ir_noise_per_m", ir_noise_per_m, {{0, 1}, "", "increase of ir_noise_m per metre of distance"});
    ode.field("ir_flat_m", ir_flat_m, {{0, 1}, "m", "limit that measured distances approach; 0: none"});
    ode.field("ir_reading_spread", ir_reading_spread,
              {{0, 0.3}, "", "s.d., over pairs of robots, of a factor on measured distances"});
  }
};

}  // namespace arkmesh::sim_ode
