// Brings what several cameras detected together on the arena plane: one observation for each robot, however many
// cameras saw it.
#pragma once

#include <span>
#include <vector>

#include "tracker/camera/calibration.hpp"
#include "tracker/detect/detection.hpp"
#include "tracker/follow/fused_observation.hpp"
#include "tracker/follow/not_given.hpp"

namespace arkmesh::tracker {

struct Body {
  double diameter_m = not_given;
  double board_m = not_given;  // of the board's edge above the arena: that is what is found in pictures
  double led_m = not_given;    // of the LED
};

// How far what is found in pictures is off at random: standard deviations, estimated as those of motion (motion.hpp).
// An LED's is what the tracker learns in the film (0.16) and under the emulator (0.11).
struct LookNoise {
  double centre_px = 0.04;  // of a robot's centre
  double led_px = 0.15;     // of an LED
};

// One camera's detections on the arena plane. Leaves out what the camera cannot place and what lies mostly outside its
// picture.
std::vector<FusedObservation> on_arena(const Calibration& camera, std::span<const Detection> detections,
                                       const Body& body, const LookNoise& noise = {});

// Observations of different cameras that must be the same robot, because bodies cannot overlap, become one: places and
// headings weighted by their certainty, the colour of the one surest of it. `views[i]` is camera i's.
std::vector<FusedObservation> fuse(std::span<const std::vector<FusedObservation>> views, const Body& body);

}  // namespace arkmesh::tracker
