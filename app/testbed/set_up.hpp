// A lab's arena for a set-up procedure, from the lab's file.
#pragma once

#include <string>
#include <vector>

#include "hal/stop_request.hpp"
#include "testbed/set_up_arena.hpp"

namespace arkmesh::app {

// `program`: what simulated robots run instead of the lab's controller, the name of a file in firmware/, or
// nothing. Throws ConfigError, and std::runtime_error when the testbed does not get ready.
testbed::SetUpArena make_set_up_arena(const std::string& file, const std::vector<std::string>& sets,
                                      const std::string& program, hal::StopRequest& stop);

}  // namespace arkmesh::app
