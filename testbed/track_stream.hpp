// `arkmesh track` of a video, a clip's folder, a camera or a URL: follows the robots and writes, draws, shows or
// publishes them.
#pragma once

#include <cstdint>
#include <string>

#include "hal/progress.hpp"
#include "hal/stop_request.hpp"
#include "testbed/kilobot_tracking.hpp"

namespace arkmesh::testbed {

struct StreamOptions {
  std::string source, calibration, camera, csv, video, png, explain, publish;
  bool json = false;
  int serve_port = -1;  // -1: nobody is shown anything; 0 takes any free port
  double led_offset_deg = testbed::led_offset_deg, diameter_px = 0;
  double seconds = 0;  // of the source's time; 0: to its end, or until Ctrl-C
};

// False when some pictures of a recording could not be read; each was named. Throws std::runtime_error with one
// sentence.
bool track_stream(const StreamOptions& options, hal::StopRequest& stop, hal::Progress& progress);

}  // namespace arkmesh::testbed
