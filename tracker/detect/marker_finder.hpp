// Finds square markers (ArUco, AprilTag) in one picture: their numbers and corners, in pixels. Remembers nothing of a
// picture.
#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "tracker/camera/calibration.hpp"

namespace arkmesh::tracker {

struct Marker {
  int number = 0;
  std::array<Point, 4> corners_px;  // clockwise as printed, from the upper left
  Point middle_px() const;
  double side_px() const;  // the longest
};

class MarkerFinder {
 public:
  // The names of families that can be found: "apriltag_36h11", "aruco_4x4_50", ...
  static const std::vector<std::string>& families();
  // How many numbers a family has, from 0.
  static int numbers(const std::string& family);
  // How many squares of its pattern a marker's side has, with the black rim: a blur of one hides it.
  static int squares(const std::string& family);

  explicit MarkerFinder(const std::string& family);
  ~MarkerFinder();
  MarkerFinder(MarkerFinder&&) noexcept;

  // In that part of the picture, each number once, ascending; a number that is there twice is left out and told in
  // `twice`. `bgr` has 8 bits, in three channels or one.
  std::vector<Marker> find(const cv::Mat& bgr, cv::Rect part, std::vector<int>* twice = nullptr) const;

 private:
  struct Family;
  std::unique_ptr<Family> family_;
};

// Draws a marker of so many pixels a side, with its white rim of one square around it; black is 0.
cv::Mat marker_picture(const std::string& family, int number, int pixels_a_square);

}  // namespace arkmesh::tracker
