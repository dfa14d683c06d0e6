// What `arkmesh doctor` says of the hardware of a table: serial ports and cameras of this machine, and those that a
// lab's file names. Opens nothing that is not named.
#pragma once

#include <vector>

#include "hal/config.hpp"
#include "testbed/finding.hpp"

namespace arkmesh::testbed {

// USB serial ports, and cameras, of this machine: whether there are any, and whether they may be used. None is no
// problem: a lab may have them elsewhere, or not at all.
std::vector<Finding> serial_ports();
std::vector<Finding> cameras();

// [arena]'s `kilobot.port` and `kilobot.cameras`: whether they can be opened now, and whether each camera's calibration
// fits its pictures. Opening a controller's line may restart the controller. Takes some seconds.
std::vector<Finding> table_of(const hal::Section& arena);

}  // namespace arkmesh::testbed
