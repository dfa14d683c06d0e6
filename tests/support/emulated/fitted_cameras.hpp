// Cameras of an emulated testbed calibrated as a lab calibrates its own: with pictures of a chessboard, and marks in
// the arena clicked by hand.
#pragma once

#include <string>
#include <vector>

#include "emulator/emulator.hpp"
#include "tracker/camera/calibration.hpp"

namespace arkmesh::tests {

struct ByHand {
  int boards = 20;        // pictures of the chessboard for each camera
  double click_px = 0.4;  // standard deviation of each coordinate of a click
  std::uint64_t seed = 1;
};

struct FittedCamera {
  tracker::Calibration calibration;
  double lens_error_px = 0, marks_error_px = 0, marks_error_mm = 0;  // as `arkmesh calibrate` says them
  double worst_mm = 0;  // off the truth, of places at the height of robots' boards where the camera sees the arena
  double worst_within_mm = 0;  // the same, of places a tenth of the picture or more from its border
};

// Throws std::runtime_error as the fit does.
FittedCamera fit_by_hand(const emulator::Emulator& emulator, std::size_t camera, const ByHand& options = {});

// Known without error.
tracker::Calibration true_calibration(const emulator::CameraModel& model, double arena_width_m, double arena_height_m);

}  // namespace arkmesh::tests
