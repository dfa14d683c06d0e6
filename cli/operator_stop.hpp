// Ctrl-C, or SIGTERM, as a wish that work ends in good order.
#pragma once

namespace arkmesh::cli {

// True once somebody has wished it; begins to listen at the first call. Who wishes it a second time ends the process at
// once, which may be waiting for something.
bool operator_stops();

}  // namespace arkmesh::cli
