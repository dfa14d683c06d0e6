// The shared world as one lab merged it at a boundary, for viewers: channels `shared` and `overlay`.
#pragma once

#include <vector>

#include "hal/bus.hpp"
#include "lab/exchange/merged_state.hpp"
#include "lab/lab_data.hpp"

namespace arkmesh::lab {

// Publishes it, and what the scenario drew. `merged`: the states in force from the boundary that `lab` has just passed.
void publish_shared(hal::Bus& bus, const LabData& lab, const std::vector<MergedState>& merged);

}  // namespace arkmesh::lab
