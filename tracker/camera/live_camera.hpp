// Cameras that do not wait for anybody: the newest picture is there when it is wanted, older ones are gone.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "hal/counters.hpp"
#include "hal/types.hpp"
#include "tracker/camera/camera_controls.hpp"

namespace arkmesh::tracker {

// How a picture came.
struct Arrival {
  hal::LabTime age{0};             // when it was asked for: since the camera's driver had it, else since it was here
  std::vector<std::uint8_t> jpeg;  // the bytes that it was decoded from (decode_jpeg); empty: it was no JPEG
};

// One camera as the watch sees it. Never blocks.
class CameraFeed {
 public:
  virtual ~CameraFeed() = default;
  // The newest picture that no earlier call has given, 8-bit BGR; empty when there is none.
  virtual cv::Mat newest() = 0;
  // Of the picture that the last newest() gave.
  virtual Arrival arrival() const { return {}; }
  // Empty while pictures come that can be used; else one sentence.
  virtual std::string error() const = 0;
  // What error() was since the last call, however briefly: a few sentences, the oldest first.
  virtual std::vector<std::string> faults() { return {}; }
  // camera.gone (each time it went), camera.skipped (pictures nobody took before a newer one came),
  // camera.refused.damaged (pictures whose bytes could not be decoded), camera.refused.changed (pictures of another
  // size than those before).
  virtual hal::Counters counters() const = 0;
};

struct CameraRequest {
  std::string source;               // a camera's number, /dev/video..., or URL
  int width_px = 0, height_px = 0;  // asked of a camera at this machine; 0: any
  CameraControls controls = {};     // of a camera at this machine, set at each opening
};

// Does not throw: a camera that is not there yet is looked for again and again, first after half a second, then after
// up to 8 s. Reading blocks, so each camera has a thread, and each URL a process (picture_child) that is given up when
// it hangs.
std::unique_ptr<CameraFeed> open_camera(const CameraRequest& camera);

// How a watch opens a camera; an emulated testbed may bring its own.
using OpenCamera = std::function<std::unique_ptr<CameraFeed>(const CameraRequest& camera)>;

}  // namespace arkmesh::tracker
