// Finds a lens from pictures of a chessboard, and a camera's place from the arena's corners or from marks on it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tracker/camera/calibration.hpp"

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

struct ChessboardSize {
  int columns = 7, rows = 6;  // of inner corners
  double square_mm = 25;
};

struct FittedLens {
  Lens lens;
  double error_px = 0;        // root mean square, of the model taken
  double other_error_px = 0;  // of the other one; infinite when it does not fit at all
  double error_mm = 0;        // error_px on the boards
  int pictures = 0;
  std::vector<std::string> doubts;  // sentences, each of a number that the pictures leave uncertain
};

class LensFit {
 public:
  explicit LensFit(const ChessboardSize& board);
  ~LensFit();
  // False when no whole chessboard is found in the picture. Throws std::runtime_error with the end of a sentence when
  // it has another size than those before.
  bool add(const cv::Mat& picture);
  // A fisheye when it fits clearly better, or when a pinhole's distortion folds over within the picture; else a
  // pinhole. Throws std::runtime_error with one sentence when there are too few pictures, when they show the board from
  // one direction only, or when neither fits.
  FittedLens fit() const;

 private:
  struct Boards;
  std::unique_ptr<Boards> boards_;
};

// A point of the arena whose place is known, and where a picture shows it.
struct Mark {
  Point in_pixels, in_arena;
};

// From four marks or more, spread over the view: for cameras that do not see the whole arena. The error is that of the
// marks. Throws std::runtime_error with one sentence when no camera sees them so.
CameraData place_camera(const Lens& lens, std::span<const Mark> marks, double arena_width_m, double arena_height_m);

// `corners`: where the arena's corners are in the picture, from the north-west one clockwise. Throws
// std::runtime_error with one sentence when they cannot be the corners of a rectangle seen from above.
CameraData place_camera(const Lens& lens, const std::vector<Point>& corners, double arena_width_m,
                        double arena_height_m);

}  // namespace arkmesh::tracker
