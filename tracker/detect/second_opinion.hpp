// What the trained net says of the robots that the search by edges found, and of those that it missed.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "tracker/detect/body_search.hpp"
#include "tracker/detect/search_net.hpp"

namespace arkmesh::tracker {

inline constexpr double surely_net = 0.5;        // of the net's scores, where it must agree
inline constexpr std::size_t enough_robots = 3;  // to believe that a picture shows robots

class SecondOpinion {
 public:
  SecondOpinion(const DetectorSettings& settings, BodySearch& bodies) : settings_(settings), bodies_(bodies) {}

  // Takes a picture, which must outlive the other calls.
  void look_at(const cv::Mat& bgr);
  // Adds robots of the others' size. Where the net sees less than half of what was found, or sees much larger ones
  // there, or nothing was found, it looks for robots of any size, if `any_size`.
  std::vector<Candidate> with_more(std::vector<Candidate> robots, bool any_size);
  // How surely the net sees each at its place.
  std::vector<double> scores(const std::vector<Candidate>& robots);

 private:
  // What else was found: at most two robots, so that one must look like a robot; more, so that one may look as it
  // likes; robots whose edges are weak, where a likely circle will do, or that of the net.
  enum class Beside { few, clear, weak };
  struct Agreed {
    std::size_t places = 0, sizes = 0;
  };

  std::vector<Candidate> of_any_size(std::size_t agreed);
  Agreed agreement(const std::vector<Candidate>& robots);
  std::vector<Candidate> joined(std::vector<Candidate> robots, Beside beside);
  // Robots of that size which the net sees and whose edge can be measured, beside those that are known.
  std::vector<Candidate> seen(double r_px, Beside beside, std::span<const Candidate> known = {});
  // Fills finds_.
  void find(double r_px);

  const DetectorSettings& settings_;
  BodySearch& bodies_;
  SearchNet net_;
  cv::Mat bgr_;
  std::vector<NetFind> finds_;
  double finds_r_px_ = 0;  // the size that they were asked for; 0: several
};

}  // namespace arkmesh::tracker
