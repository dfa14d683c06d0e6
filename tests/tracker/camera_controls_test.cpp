// Exposure, gain and white balance, against a stand-in of a camera's driver.
#include "tracker/camera/camera_controls.hpp"

#include <doctest/doctest.h>
#include <linux/videodev2.h>

#include <cerrno>
#include <map>
#include <utility>
#include <vector>

using namespace arkmesh::tracker;

namespace {

// Answers as a driver of Video4Linux does: values only within their range, an exposure only once the automatic is off.
struct Driver {
  struct Range {
    std::int32_t low, high, step, value;
    bool disabled = false;
  };
  std::map<std::uint32_t, Range> controls{{V4L2_CID_EXPOSURE_AUTO, {0, 3, 1, V4L2_EXPOSURE_APERTURE_PRIORITY}},
                                          {V4L2_CID_EXPOSURE_ABSOLUTE, {3, 2047, 1, 250}},
                                          {V4L2_CID_AUTOGAIN, {0, 1, 1, 1}},
                                          {V4L2_CID_GAIN, {0, 255, 5, 64}},
                                          {V4L2_CID_AUTO_WHITE_BALANCE, {0, 1, 1, 1}},
                                          {V4L2_CID_WHITE_BALANCE_TEMPERATURE, {2000, 6500, 1, 4000}}};
  std::vector<std::pair<std::uint32_t, std::int32_t>> set;
  bool keeps_own = false;  // takes every value and changes none

  int operator()(unsigned long request, void* argument) {
    const auto fail = [](int code) {
      errno = code;
      return -1;
    };
    if (request == VIDIOC_QUERYCTRL) {
      auto& about = *static_cast<v4l2_queryctrl*>(argument);
      if (!controls.contains(about.id)) return fail(EINVAL);
      const Range& range = controls.at(about.id);
      about.minimum = range.low, about.maximum = range.high, about.step = range.step;
      about.flags = range.disabled ? V4L2_CTRL_FLAG_DISABLED : 0;
      return 0;
    }
    auto& value = *static_cast<v4l2_control*>(argument);
    if (!controls.contains(value.id)) return fail(EINVAL);
    Range& range = controls.at(value.id);
    if (request == VIDIOC_G_CTRL) return value.value = range.value, 0;
    if (request != VIDIOC_S_CTRL) return fail(ENOTTY);
    if (value.value < range.low || value.value > range.high) return fail(ERANGE);
    if (value.id == V4L2_CID_EXPOSURE_ABSOLUTE && is(V4L2_CID_EXPOSURE_AUTO) == V4L2_EXPOSURE_APERTURE_PRIORITY)
      return fail(EIO);
    set.emplace_back(value.id, value.value);
    if (!keeps_own) range.value = value.value / range.step * range.step;
    return 0;
  }
  std::int32_t is(std::uint32_t id) const { return controls.at(id).value; }
  std::string told(const CameraControls& wanted) {
    return set_controls(wanted, "0",
                        [this](unsigned long request, void* argument) { return (*this)(request, argument); });
  }
};

}  // namespace

TEST_CASE("a camera's exposure, gain and white balance are set, and its own automatics are off") {
  // Proves the driver's units, the order, that drivers may round, and that a key that is not given changes nothing.
  Driver driver;
  CHECK(driver.told({}).empty());
  CHECK(driver.set.empty());
  CHECK(driver.told({.exposure_ms = 8.3, .gain = 32, .white_balance_k = 4600}).empty());
  CHECK(driver.is(V4L2_CID_EXPOSURE_AUTO) == V4L2_EXPOSURE_MANUAL);
  CHECK(driver.is(V4L2_CID_EXPOSURE_ABSOLUTE) == 83);
  CHECK(driver.is(V4L2_CID_AUTOGAIN) == 0);
  CHECK(driver.is(V4L2_CID_GAIN) == 30);
  CHECK(driver.is(V4L2_CID_AUTO_WHITE_BALANCE) == 0);
  CHECK(driver.is(V4L2_CID_WHITE_BALANCE_TEMPERATURE) == 4600);
  driver = {};
  CHECK(driver.told({.gain = 200}).empty());
  CHECK(driver.is(V4L2_CID_EXPOSURE_AUTO) == V4L2_EXPOSURE_APERTURE_PRIORITY);
  CHECK(driver.is(V4L2_CID_AUTO_WHITE_BALANCE) == 1);
  // one that has no automatic
  driver.controls.erase(V4L2_CID_AUTOGAIN);
  CHECK(driver.told({.gain = 10}).empty());
  CHECK(driver.is(V4L2_CID_GAIN) == 10);
}

TEST_CASE("what a camera does not take is said with its key") {
  // Proves that nothing is out of range in silence.
  Driver driver;
  CHECK(driver.told({.exposure_ms = 500}) == "the camera 0 accepts exposure_ms from 0.3 to 204.7, not 500");
  CHECK(driver.set.empty());
  driver.controls.at(V4L2_CID_GAIN).disabled = true;
  CHECK(driver.told({.gain = 10}) == "the camera 0 has no control gain: remove this key");
  driver.controls.erase(V4L2_CID_WHITE_BALANCE_TEMPERATURE);
  CHECK(driver.told({.white_balance_k = 4000}) == "the camera 0 has no control white_balance_k: remove this key");
  driver.controls.erase(V4L2_CID_EXPOSURE_AUTO);
  driver.controls[V4L2_CID_EXPOSURE_AUTO] = {0, 0, 1, V4L2_EXPOSURE_APERTURE_PRIORITY};
  CHECK(driver.told({.exposure_ms = 10}).starts_with("the camera 0 rejects exposure_ms = 10: "));
  Driver deaf;
  deaf.keeps_own = true;
  CHECK(deaf.told({.white_balance_k = 5000}) ==
        "the camera 0 has white_balance_k = 4000 although it was set to 5000: does another program set it?");
}
