// A gateway as a process of its own: one thread, one loop with the sockets, the bus by its descriptor, and a timer.
// Gives way when somebody else is at work on its LCM port.
#pragma once

#include "gateway/process_config.hpp"

namespace arkmesh::gateway {

// Says on standard output what changes. Returns when SIGINT or SIGTERM asks for it. Throws hal::ConfigError when
// another lab or gateway was on the LCM port before, std::runtime_error when the TCP port is taken.
void run_gateway(ProcessConfig config);

}  // namespace arkmesh::gateway
