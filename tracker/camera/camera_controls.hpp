// Exposure, gain and white balance of a camera at this machine, through the controls of Video4Linux.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace arkmesh::tracker {

// A value that is not a number leaves the camera as it is.
struct CameraControls {
  double exposure_ms = std::numeric_limits<double>::quiet_NaN();
  double gain = std::numeric_limits<double>::quiet_NaN();  // in the driver's units
  double white_balance_k = std::numeric_limits<double>::quiet_NaN();

  // The keys whose values are numbers.
  std::vector<std::string> keys() const;
};

// ioctl(2) on the open device: -1 and errno, or not negative.
using DeviceControl = std::function<int(unsigned long request, void* argument)>;

// Switches the camera's own automatic off and sets what is a number; `shown` is the camera's name in sentences. Empty,
// or one sentence of the first value that the camera does not take.
std::string set_controls(const CameraControls& controls, const std::string& shown, const DeviceControl& control);

}  // namespace arkmesh::tracker
