// What `arkmesh doctor` says of the hardware that a lab's file names: its overhead controller and its cameras.
#pragma once

#include <vector>

#include "hal/config/config.hpp"
#include "hal/finding.hpp"
#include "testbed/kilobot_settings.hpp"

namespace arkmesh::testbed {

// One camera of `all`, and whether its calibration fits its pictures.
hal::Finding find_camera(const CameraSettings& settings, std::size_t number, std::size_t all);

// Whether messages can name the robots' ids; [arena]'s `kilobot.port` and `kilobot.cameras`: whether they can be opened
// now, and whether each camera's calibration fits its pictures. Opening a controller's line may restart the controller.
// Takes some seconds.
std::vector<hal::Finding> find_devices(const hal::Section& arena);

}  // namespace arkmesh::testbed
