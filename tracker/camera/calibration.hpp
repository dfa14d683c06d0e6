// How one camera's pixels and the arena belong together: lens, place of the camera, and the height of what is looked
// at. Pure geometry; files are calibration_file's.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace arkmesh::tracker {

// Pixels (x right, y down, the top-left pixel's centre is (0, 0)) or metres of the arena frame (x east, y north), as
// the name says.
struct Point {
  double x = 0, y = 0;
};

using Matrix3 = std::array<double, 9>;  // row by row

enum class LensModel { pinhole, fisheye };

// In the conventions of OpenCV's calib3d.
struct Lens {
  LensModel model = LensModel::pinhole;
  int width_px = 0, height_px = 0;            // of the pictures that this is for
  Matrix3 matrix{1, 0, 0, 0, 1, 0, 0, 0, 1};  // K, with skew if need be
  std::vector<double> distortion;  // pinhole: none, 4, 5 or 8 coefficients (k1 k2 p1 p2 [k3 [k4 k5 k6]]); fisheye: 4
};

struct CameraData {
  Lens lens;
  Matrix3 rotation{1, 0, 0, 0, -1, 0, 0, 0, -1};  // X_camera = rotation X_arena + translation; z is up from the arena
  std::array<double, 3> translation_m{0, 0, 1};
  double arena_width_m = 1, arena_height_m = 1;
  double error_px = 0, error_mm = 0;  // how well it fits what it was made from; for people
};

class Calibration {
 public:
  // Throws std::invalid_argument with one sentence when no camera can be like that.
  explicit Calibration(CameraData data);
  // For pictures of which nothing is known: straight from above, from so far away that height does not matter.
  static Calibration overhead(int width_px, int height_px, double metres_per_px);

  const CameraData& data() const { return data_; }
  // Of the camera, in the arena frame; the third is its height above the arena.
  const std::array<double, 3>& position_m() const { return position_m_; }
  // Where a point of the arena is in the picture, inside its frame or not; nothing when it is behind the camera or
  // beyond the lens's reach.
  std::optional<Point> to_pixel(Point in_arena, double height_m) const;
  // The point at that height that is seen in a pixel; nothing when the line of sight does not meet it.
  std::optional<Point> to_arena(Point in_pixels, double height_m) const;
  // Pixels per metre near a point: the larger and the smaller over all directions. Nothing where the camera cannot
  // look.
  struct Scale {
    double largest = 0, smallest = 0;
  };
  std::optional<Scale> scale(Point in_arena, double height_m) const;
  // Pixels from the picture's nearest edge; negative outside.
  double inside_px(Point in_pixels) const;

 private:
  std::optional<Point> ideal(Point in_pixels) const;
  Point distorted(Point ideal) const;
  double radial(double radius) const;

  CameraData data_;
  Matrix3 inverse_matrix_{};
  std::array<double, 3> position_m_{};  // of the camera, in the arena frame
  double reach_ = 0;  // ideal radius (pinhole) or angle (fisheye) up to which the distortion is a mapping
};

}  // namespace arkmesh::tracker
