// A small net that was trained to find robots in pictures where they have a radius of some 5 pixels: it says where
// robots of one size are, coarsely. tracker/training/ says how it came to be.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "tracker/detect/circle.hpp"

namespace arkmesh::tracker {

struct NetFind {
  Circle circle;     // to some 5 % of its radius
  double score = 0;  // 0..1, a probability in the rooms of tracker/training/
};

class SearchNet {
 public:
  SearchNet();
  ~SearchNet();
  SearchNet(SearchNet&&) noexcept;
  SearchNet& operator=(SearchNet&&) noexcept;

  // Takes an 8-bit BGR picture, which must outlive the calls of find().
  void look_at(const cv::Mat& bgr);
  // Adds the robots whose radius is within some 30 % of r_px, the surest of each place.
  void find(double r_px, double min_score, std::vector<NetFind>& found);

 private:
  struct Net;
  std::unique_ptr<Net> net_;
  std::vector<cv::Mat> halves_;  // the picture, and half as large each
};

}  // namespace arkmesh::tracker
