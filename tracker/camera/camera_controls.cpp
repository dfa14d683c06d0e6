#include "tracker/camera/camera_controls.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace arkmesh::tracker {
namespace {

struct Control {
  const char* key;
  double CameraControls::*value;
  std::uint32_t id, automatic;
  std::int32_t automatic_off;
  double units;  // of the driver, in one of the key
};
constexpr std::array<Control, 3> all_controls{{
    {"exposure_ms", &CameraControls::exposure_ms, V4L2_CID_EXPOSURE_ABSOLUTE, V4L2_CID_EXPOSURE_AUTO,
     V4L2_EXPOSURE_MANUAL, 10},
    {"gain", &CameraControls::gain, V4L2_CID_GAIN, V4L2_CID_AUTOGAIN, 0, 1},
    {"white_balance_k", &CameraControls::white_balance_k, V4L2_CID_WHITE_BALANCE_TEMPERATURE,
     V4L2_CID_AUTO_WHITE_BALANCE, 0, 1},
}};

bool has(const DeviceControl& control, v4l2_queryctrl& about) {
  return control(VIDIOC_QUERYCTRL, &about) >= 0 && (about.flags & V4L2_CTRL_FLAG_DISABLED) == 0;
}

bool set(const DeviceControl& control, std::uint32_t id, std::int32_t value) {
  v4l2_control asked{.id = id, .value = value};
  return control(VIDIOC_S_CTRL, &asked) >= 0;
}

std::string set_one(const Control& one, double value, const std::string& shown, const DeviceControl& control) {
  v4l2_queryctrl about{}, automatic{};
  about.id = one.id;
  automatic.id = one.automatic;
  if (!has(control, about)) return fmt::format("the camera {} has no control {}: remove this key", shown, one.key);
  const double low = about.minimum / one.units, high = about.maximum / one.units;
  if (value < low || value > high)
    return fmt::format("the camera {} accepts {} from {} to {}, not {}", shown, one.key, low, high, value);
  const auto wanted = static_cast<std::int32_t>(std::lround(value * one.units));
  v4l2_control set_to{.id = one.id, .value = 0};
  errno = 0;
  if ((has(control, automatic) && !set(control, one.automatic, one.automatic_off)) || !set(control, one.id, wanted) ||
      control(VIDIOC_G_CTRL, &set_to) < 0)
    return fmt::format("the camera {} rejects {} = {}: {}", shown, one.key, value, std::strerror(errno));
  if (std::abs(set_to.value - wanted) > about.step)  // drivers round
    return fmt::format("the camera {} has {} = {} although it was set to {}: does another program set it?", shown,
                       one.key, set_to.value / one.units, value);
  return {};
}

}  // namespace

std::vector<std::string> CameraControls::keys() const {
  std::vector<std::string> out;
  for (const Control& one : all_controls)
    if (!std::isnan(this->*one.value)) out.emplace_back(one.key);
  return out;
}

std::string set_controls(const CameraControls& controls, const std::string& shown, const DeviceControl& control) {
  for (const Control& one : all_controls) {
    const double value = controls.*one.value;
    if (std::isnan(value)) continue;
    if (std::string error = set_one(one, value, shown, control); !error.empty()) return error;
  }
  return {};
}

}  // namespace arkmesh::tracker
