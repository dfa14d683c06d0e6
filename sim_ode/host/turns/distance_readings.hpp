// How strongly a robot's receiver sees a sender at some distance: the straight lines of the library's calibration
// tables, the same for all robots.
#pragma once

#include <array>
#include <cstdint>

namespace arkmesh::sim_ode {

// Readings of both gains, 0..1023, for a gap of k x 5 mm between bodies: those of a typical robot.
inline constexpr std::array<std::uint16_t, 14> high_gain_table = {1000, 930, 860, 790, 720, 650, 585,
                                                                  525,  470, 420, 375, 335, 300, 270};
inline constexpr std::array<std::uint16_t, 14> low_gain_table = {900, 640, 500, 400, 330, 275, 232,
                                                                 198, 170, 147, 128, 112, 98,  86};

// What robots measure of the overhead controller, until a source says.
inline constexpr double assumed_overhead_m = 0.143;

struct DistanceReadings {
  std::int16_t low_gain, high_gain;
};
// `distance_m` is between centres. estimate_distance() makes the same distance of them again.
DistanceReadings readings_at(double distance_m);

}  // namespace arkmesh::sim_ode
