// What `arkmesh doctor` says of the hardware that a lab's file names: its overhead controller and its cameras.
#pragma once

#include <vector>

#include "hal/config/config.hpp"
#include "hal/finding.hpp"

namespace arkmesh::testbed {

// Whether messages can name the robots' ids; [arena]'s `kilobot.port` and `kilobot.cameras`: whether they can be opened
// now, and whether each camera's calibration fits its pictures. Opening a controller's line may restart the controller.
// Takes some seconds.
std::vector<hal::Finding> find_devices(const hal::Section& arena);

}  // namespace arkmesh::testbed
