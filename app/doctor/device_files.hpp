// Which USB serial ports and cameras this machine has, and whether one may use them. Opens nothing.
#pragma once

#include <vector>

#include "hal/finding.hpp"

namespace arkmesh::app {

// None is no problem: a lab may have them elsewhere, or not at all.
std::vector<hal::Finding> serial_ports();
std::vector<hal::Finding> cameras();

}  // namespace arkmesh::app
