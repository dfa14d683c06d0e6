// A gateway as a process of its own: one thread, one loop with the sockets, the bus by its descriptor, and a timer.
// Gives way when somebody else is at work on its LCM port.
#pragma once

#include "hal/config.hpp"

namespace arkmesh::gateway {

// The gateway of the lab whose file this is. Says on standard output what changes. Returns when SIGINT or SIGTERM asks
// for it. Throws hal::ConfigError for a wrong file, and when another lab or gateway was on the LCM port before;
// std::runtime_error when the TCP port is taken.
void run_gateway(const hal::Config& config);

}  // namespace arkmesh::gateway
