// A gateway as a process of its own: one thread, one loop with the sockets, the bus by its descriptor, and a timer.
// Gives way when somebody else is at work on its LCM port. Reads its file again when SIGHUP comes, or somebody asks
// by a local socket.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "hal/config.hpp"

namespace arkmesh::gateway {

// The gateway of the lab whose file `read` reads, again for each SIGHUP or reload_gateways: the rules change then, and
// what else is different is said. Says on standard output what changes. Returns when SIGINT or SIGTERM asks for it, or
// when the terminal that it was started in is closed. Throws hal::ConfigError for a wrong file, and when another lab or
// gateway was on the LCM port before; std::runtime_error when the TCP port is taken.
void run_gateway(const std::function<hal::Config()>& read);

// Makes the gateways that run with this file, of this user, read it again. Returns what each says, in lines; nothing
// when none runs. Throws hal::ConfigError for a file that one of them does not take.
std::vector<std::string> reload_gateways(const std::filesystem::path& file);

// Throws hal::ConfigError when a gateway cannot run with this file.
void check_gateway_file(const hal::Config& config);

}  // namespace arkmesh::gateway
