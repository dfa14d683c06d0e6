// Cameras that do not wait for anybody: the newest picture is there when it is wanted, older ones are gone.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "hal/counters.hpp"
#include "hal/wall_time.hpp"

namespace arkmesh::tracker {

// How a picture came.
struct Arrival {
  hal::TimePoint at{};             // when the camera gave it; the clock's beginning when that is not known
  std::vector<std::uint8_t> jpeg;  // the bytes that it was decoded from (cv::imdecode, in colour); empty: not kept
};

// One camera as the watch sees it. Never blocks.
class CameraFeed {
 public:
  virtual ~CameraFeed() = default;
  // The newest picture that no earlier call has given, 8-bit BGR; empty when there is none.
  virtual cv::Mat newest() = 0;
  // Of the picture that the last newest() gave.
  virtual Arrival arrival() const { return {}; }
  // Empty while pictures come; else one sentence.
  virtual std::string error() const = 0;
  // camera.gone (each time it went), camera.skipped (pictures nobody took before a newer one came),
  // camera.refused.damaged (pictures whose bytes could not be decoded).
  virtual hal::Counters counters() const = 0;
};

// A camera's number, /dev/video..., or URL. Does not throw: a camera that is not there yet is looked for again and
// again, first after half a second, then after up to 8 s. OpenCV blocks while it reads, so each camera has a thread;
// one that hangs is given up after some seconds by OpenCV's own time limits. width_px and height_px are asked of a
// camera at this machine when not 0.
std::unique_ptr<CameraFeed> open_camera(const std::string& source, int width_px = 0, int height_px = 0);
// The same, and arrivals hold the bytes of pictures that a camera at this machine delivers as JPEG. What is decoded
// from them is what open_camera gives: OpenCV decodes such cameras' pictures by the same function.
std::unique_ptr<CameraFeed> open_camera_with_bytes(const std::string& source, int width_px, int height_px);

// How a watch opens a camera's source; an emulated testbed may bring its own.
using OpenCamera = std::function<std::unique_ptr<CameraFeed>(const std::string& source, int width_px, int height_px)>;

}  // namespace arkmesh::tracker
