// Finds robots in one picture by what is physical about them: a round board whose outer edge has one size throughout a
// view, a dark ring round a paler coin cell, one LED near the edge. Knows neither ids nor the arena; remembers of a
// picture only the robots' size, and where the last search found some.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tracker/detect/detection.hpp"
#include "tracker/detect/explanation.hpp"

namespace cv {
class Mat;
}

namespace arkmesh::tracker {

struct DetectorSettings {
  double smallest_diameter_px = 10;  // what is smaller is no robot; used only while the size is not known
  double largest_diameter_px = 420;  // what is larger is no robot; likewise
  std::optional<double>
      diameter_px;  // known from a calibration; else found in the first picture with three robots, and remembered
  bool diameter_told = false;       // by a person: what is found without it counts, too, if it is about as large
  double diameter_tolerance = 0.2;  // robots of one view differ from the common size by at most this part of it
  double min_confidence = 0.5;      // detections below it are not reported
};

// Where a robot should be, and how far off it may be.
struct Expected {
  double x_px = 0, y_px = 0, r_px = 0;
  double reach_px = 0;
};

// Pictures are 8-bit BGR; anything else is an std::invalid_argument. One detector per camera and thread: it keeps its
// working buffers.
class Detector {
 public:
  explicit Detector(const DetectorSettings& settings = {});
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  // The whole picture, strongest evidence first; no two results overlap by more than robots can.
  // `explanation`: filled if it is wanted.
  std::vector<Detection> search(const cv::Mat& bgr, Explanation* explanation = nullptr);
  // Only windows round the expected places; result i belongs to where[i], empty when no robot is seen there. One robot
  // is given to one place at most: the nearest.
  std::vector<std::optional<Detection>> follow(const cv::Mat& bgr, std::span<const Expected> where);

  // The common diameter: of the settings, or as learnt so far.
  std::optional<double> diameter_px() const;

 private:
  class Search;
  std::unique_ptr<Search> search_;
};

}  // namespace arkmesh::tracker
