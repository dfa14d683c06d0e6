// A gateway as a process of its own: one thread, one loop with the sockets, the bus by its descriptor, and a timer.
// Gives way when somebody else is at work on its LCM port. Reads its file again when SIGHUP comes, or somebody asks
// by a local socket.
#pragma once

#include <functional>

#include "hal/config/config.hpp"

namespace arkmesh::gateway {

// The gateway of the lab whose file `read` reads, again for each SIGHUP or reload_gateways (gateway/reload_door.hpp):
// the rules change then, and what else is different is said. Says on standard output what changes. Returns when SIGINT
// or SIGTERM asks for it, or when the terminal that it was started in is closed. Throws hal::ConfigError for a wrong
// file, and when another lab or gateway was on the LCM port before; std::runtime_error when the TCP port is taken.
void run_gateway(const std::function<hal::Config()>& read);

// Throws hal::ConfigError when a gateway cannot run with this file.
void check_gateway_file(const hal::Config& config);

}  // namespace arkmesh::gateway
