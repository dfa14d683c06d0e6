// Robots of other labs, as the virtual sensors of this lab take them: its key sensors.presence says.
#pragma once

#include <vector>

#include "lab/lab.hpp"
#include "scenarios/kit/neighbours.hpp"
#include "scenarios/kit/sectors.hpp"

namespace arkmesh::scenarios::kit {

// Where they are in this arena, as merged last; none where presence = "none".
std::vector<Seen> others_in(const lab::Lab& lab);
// Their no-walk zones, of the lab's radius; none but where presence = "no-walk".
std::vector<Surroundings::Disc> no_walk_zones(const lab::Lab& lab);
// Discs of one radius around robots.
std::vector<Surroundings::Disc> discs_around(const std::vector<Seen>& robots, double radius_m);

}  // namespace arkmesh::scenarios::kit
