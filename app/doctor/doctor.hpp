// What on this machine would keep labs from working, and the command that mends it. Looks only; changes nothing.
#pragma once

#include <vector>

#include "hal/config/config.hpp"
#include "hal/finding.hpp"

namespace arkmesh::app {

// Sends one multicast datagram and waits for it, at most a second, as LCM does when it starts.
hal::Finding multicast();

// Everything else that any lab needs: limits, programs, free space.
std::vector<hal::Finding> machine();

// What one lab's file needs: its LCM port to itself, which takes a second and a half and works only where multicast
// does, and its TCP port. Throws ConfigError.
std::vector<hal::Finding> lab_ports(const hal::Section& root, bool multicast_works);

}  // namespace arkmesh::app
