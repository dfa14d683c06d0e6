// How a lab sees the shared world: the lab's name for what views on its pictures need as well.
#pragma once

#include "hal/projection.hpp"

namespace arkmesh::lab {

using hal::Projection;

}  // namespace arkmesh::lab
