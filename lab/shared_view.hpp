// The shared world as one lab merged it at a boundary, for viewers: channel `shared`.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "arkmesh/shared_view_t.hpp"
#include "hal/types.hpp"
#include "lab/lab_state.hpp"
#include "lab/projection.hpp"

namespace arkmesh::lab {

// `merged`: the states in force from boundary `period`, which is at lab time `stamp`. `projection` is the own lab's.
shared_view_t make_shared_view(std::uint32_t period, hal::LabTime stamp, const Projection& projection,
                               const std::vector<std::pair<std::string, const LabState*>>& merged);

}  // namespace arkmesh::lab
