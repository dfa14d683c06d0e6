// The options of `arkmesh calibrate`, and what their texts mean. All that read them throw CLI::ValidationError.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tracker/camera_fit.hpp"

namespace CLI {
class App;
}

namespace arkmesh::cli {

struct CalibrateOptions {
  std::vector<std::string> pictures, corners, landmarks;
  std::string board = "7x6", arena = "1x1", corner_picture, out, name = "camera0", png, ark, size = "2048x1536";
  double square_mm = 25, camera_height_m = 1.6;

  void add_to(CLI::App& command);

  std::pair<double, double> arena_sides_m() const;
  tracker::ChessboardSize chessboard() const;
  std::pair<int, int> ark_picture_px() const;
  std::vector<tracker::Point> given_corners() const;
  std::vector<tracker::Mark> given_landmarks() const;
};

}  // namespace arkmesh::cli
