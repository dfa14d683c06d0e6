// How a camera maps the arena to pixels: pinhole with Brown's distortion, in OpenCV's conventions. Pure geometry.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::emulator {

// Where a camera hangs and where it looks, arena frame, z up from the arena.
struct CameraPose {
  double x_m = 0, y_m = 0, z_m = 1.5;
  double look_x_m = 0, look_y_m = 0;  // the point of the arena in the line of sight
  double roll_rad = 0;                // about that line; at 0 the picture's upper side is the arena's north
};

// Linear part of the mapping near a point of a plane z = constant: pixels per metre.
struct LocalMap {
  double x_px = 0, y_px = 0;
  double xx = 0, xy = 0, yx = 0, yy = 0;  // d(x_px)/d(x_m), d(x_px)/d(y_m), ...
};

class CameraModel {
 public:
  CameraModel() = default;
  // Distortion k1, k2, p1, p2, k3. Throws std::invalid_argument with the end of a sentence when a camera cannot look
  // like that.
  CameraModel(int width_px, int height_px, double focal_px, double centre_x_px, double centre_y_px,
              const std::array<double, 5>& distortion, const CameraPose& pose);
  // The focal length, in pixels, at which all of `corners` (in the arena) fit into a picture with a margin of `margin`
  // of its size.
  static double focal_to_fit(int width_px, int height_px, const CameraPose& pose,
                             const std::vector<cv::Point2d>& corners, double margin);

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  // Of a point of the arena; nothing for one that is behind the camera or beyond where the distortion is a mapping.
  std::optional<cv::Point2d> project(double x_m, double y_m, double z_m) const;
  std::optional<LocalMap> project_near(double x_m, double y_m, double z_m) const;
  // Ideal direction of a pixel, in the camera's frame: (x, y, 1).
  cv::Point2d ideal(cv::Point2d pixel) const;
  // Where the sight through an ideal direction meets the plane z = z_m of the arena.
  std::optional<cv::Point2d> meets_plane(cv::Point2d ideal, double z_m) const;

  // For calibration files: arena frame to camera frame, X_camera = rotation X_arena + translation.
  const cv::Matx33d& matrix() const { return matrix_; }
  const std::array<double, 5>& distortion() const { return distortion_; }
  const cv::Matx33d& rotation() const { return rotation_; }
  const cv::Vec3d& translation() const { return translation_; }
  cv::Vec3d position() const { return -(rotation_.t() * translation_); }

 private:
  cv::Point2d distort(double x, double y) const;

  int width_px_ = 0, height_px_ = 0;
  cv::Matx33d matrix_ = cv::Matx33d::eye(), rotation_ = cv::Matx33d::eye();
  cv::Vec3d translation_;
  std::array<double, 5> distortion_{};
  double max_radius2_ = 0;  // of ideal directions: beyond it the distortion folds the picture over
};

}  // namespace arkmesh::emulator
