// Set-up procedure `identify --latency`: how long after the light each camera's pictures arrive. All robots light up to
// show their voltage, whatever their program, and are told to pause at another moment of a picture's period each time.
#pragma once

#include <string>
#include <vector>

#include "hal/progress.hpp"
#include "hal/stop_request.hpp"
#include "hal/types.hpp"
#include "testbed/set_up_arena.hpp"

namespace arkmesh::testbed {

// From the last picture with light, and the first without, to the moment when the light went out: the latency of the
// camera is between both.
struct FlashSeen {
  hal::LabTime least{0}, most{0};
};

struct CameraLatency {
  double latency_ms = 0, within_ms = 0;  // the middle of what is possible, and half of its width
  int flashes = 0, agree = 0;            // seen, and with these bounds
};

// The span that most flashes allow, the first of several; of none: 0 flashes.
CameraLatency latency_of(const std::vector<FlashSeen>& flashes);

// Of each camera. Robots stand, and need no names. Less when `stop` is. Throws std::runtime_error with one sentence: no
// cameras, no way to robots.
std::vector<CameraLatency> measure_latency(SetUpArena& arena, int flashes, hal::StopRequest& stop,
                                           hal::Progress& progress);

}  // namespace arkmesh::testbed
