// The shared world as one lab merged it at a boundary, for viewers: channels `shared` and `overlay`.
#pragma once

#include <vector>

#include "arkmesh/shared_view_t.hpp"
#include "hal/bus/bus.hpp"
#include "lab/exchange/lab_state.hpp"
#include "lab/lab_data.hpp"

namespace arkmesh::lab {

// `merged`: the states in force from the boundary that `lab` has just passed.
shared_view_t shared_view(const LabData& lab, const std::vector<MergedState>& merged);
// Publishes it, and what the scenario has drawn since.
void publish_shared(hal::Bus& bus, const LabData& lab, const shared_view_t& view);

}  // namespace arkmesh::lab
