// Where robots stand at the beginning: at random, not touching each other nor anything else, or on places that were
// checked.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/types.hpp"
#include "sim_ode/solid_bodies.hpp"

namespace arkmesh::sim_ode {

// Robots' centres lie at most `half_width_m`, `half_height_m` from the arena's centre; headings are random. Empty when
// that many do not fit.
std::vector<hal::Pose> start_places(int robots, double half_width_m, double half_height_m, const std::string& lab,
                                    std::uint64_t seed, const SolidBodies& solids);

// What is wrong with places given by hand, as the end of a sentence: a robot in or beyond a wall, two that overlap, one
// in an obstacle or an object.
// Empty when nothing is.
std::string error_with(const std::vector<hal::Pose>& places, double width_m, double height_m,
                       const SolidBodies& solids);

}  // namespace arkmesh::sim_ode
