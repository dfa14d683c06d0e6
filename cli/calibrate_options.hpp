// What people write after `arkmesh calibrate`, and what it means. What cannot be meant throws CLI::ValidationError.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tracker/camera_fit.hpp"

namespace arkmesh::cli {

struct CalibrateOptions {
  std::vector<std::string> pictures, corners, marks;
  std::string board = "7x6", arena = "1x1", corner_picture, out, name = "camera0", png, ark, size = "2048x1536";
  double square_mm = 25, camera_height_m = 1.6;
};

// Width and height of the arena, metres.
std::pair<double, double> sides_of(const CalibrateOptions& options);
// Width and height of the pictures of ARK's cameras, pixels.
std::pair<int, int> picture_size_of(const CalibrateOptions& options);
tracker::ChessboardSize board_of(const CalibrateOptions& options);
// Those given by --corner, pixels.
std::vector<tracker::Point> given_corners(const CalibrateOptions& options);
std::vector<tracker::Mark> marks_of(const CalibrateOptions& options);

}  // namespace arkmesh::cli
