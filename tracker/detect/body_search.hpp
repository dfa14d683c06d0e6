// The search for robots by their edges: Hough voting in a downsampled image, each looked at closely in the picture
// itself.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "tracker/detect/candidate.hpp"
#include "tracker/detect/detector.hpp"
#include "tracker/detect/hough_voting.hpp"

namespace arkmesh::tracker {

class BodySearch {
 public:
  explicit BodySearch(const DetectorSettings& settings) : settings_(settings) {}

  // Before anything else is asked of a picture.
  void begin(double noise) { noise_ = noise, taken_block_ = 0; }
  double noise() const { return noise_; }
  // Where objections go; null: nowhere.
  void explain(Explanation* explanation) { explanation_ = explanation; }

  // Sizes of robots, the one with most evidence first.
  std::vector<SizeEvidence> find_sizes(const cv::Mat& bgr);
  // Of a size that may be that of their coin cells.
  std::vector<Candidate> bodies_or_cells(const cv::Mat& bgr, double diameter_px);
  // Searches at neighbouring sizes together: near a limit each alone may miss a robot, and what only one finds is
  // mostly none.
  std::vector<Candidate> about_diameter(const cv::Mat& bgr, double diameter_px);
  // At one size alone.
  std::vector<Candidate> at_diameter(const cv::Mat& bgr, double diameter_px);
  // The robot nearest to an expected place, if one is within its reach.
  std::optional<Candidate> near(const cv::Mat& bgr, const Expected& place);
  std::optional<CircleFit> fit(const cv::Mat& bgr, const Circle& guess, double range, bool darker) {
    return fitter_.fit(bgr, guess, range, darker, noise_);
  }
  // Why a circle is no robot, for an explanation.
  void object(const Circle& circle, double confidence, const char* objection);
  // The surest first; no two overlap by more than robots can.
  static std::vector<Candidate> united(const cv::Mat& bgr, const std::vector<std::vector<Candidate>>& all);
  static double median_r_px(const std::vector<Candidate>& robots);

 private:
  // First on the downsampled image, where most of what is no robot shows itself; then on the picture itself.
  std::optional<CircleFit> closely(const cv::Mat& bgr, const Circle& guess, bool darker);
  // Candidates of radii [min_r_px, max_r_px], each looked at closely, until `patience` of them in a row are nothing, or
  // too many of all.
  void look(const cv::Mat& bgr, double min_r_px, double max_r_px, double min_votes, std::size_t patience,
            std::vector<Candidate>& candidates);
  // The whole picture, downsampled, unless it is so already.
  void take(const cv::Mat& bgr, int block);
  // Whether a circle is a coin cell's: board round it, and arena round that. Grey levels of the picture looked at last.
  bool in_dark_ring(const Circle& circle) const;
  // The weakest edge of the downsampled image that may vote, in grey levels a pixel.
  double min_step() const;

  DetectorSettings settings_;
  double noise_ = 0;  // of the picture looked at, in grey levels
  DownsampledImage picture_;
  int taken_block_ = 0;  // of the whole picture in picture_ and votes_; 0: they hold something else
  HoughVoting votes_;
  CircleFitter fitter_;
  std::vector<CircleVote> circle_votes_;
  Explanation* explanation_ = nullptr;
};

}  // namespace arkmesh::tracker
