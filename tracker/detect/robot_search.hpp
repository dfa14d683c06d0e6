// The search for robots: edges and a trained net propose circles, and both, with a second net that examines each
// circle, decide how probably it is a robot.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "tracker/detect/body_search.hpp"
#include "tracker/detect/look_net.hpp"
#include "tracker/detect/search_net.hpp"

namespace arkmesh::tracker {

inline constexpr std::size_t enough_robots = 3;  // to believe that a picture shows robots

class RobotSearch {
 public:
  RobotSearch(const DetectorSettings& settings, BodySearch& bodies) : settings_(settings), bodies_(bodies) {}

  // Takes a picture, which must outlive the other calls. BodySearch::begin() comes before.
  void look_at(const cv::Mat& bgr);
  // Robots of about that size, the surest first; their evidence is the probability that they are robots.
  std::vector<Candidate> about_diameter(double diameter_px);
  // Of the size for which there is most evidence, be it `diameter_px` if that is given.
  std::vector<Candidate> of_any_size(std::optional<double> diameter_px);
  // The probability that the circle is a robot's edge, by a close look alone.
  double look_closely(const cv::Mat& bgr, const Circle& circle) { return look_net_.probabilities(bgr, {circle})[0]; }
  // What was looked at where the robots returned last were found, and is none.
  const std::vector<Circle>& refused() const { return last_.refused; }

 private:
  // Robots of one size, and what was refused there.
  struct OfSize {
    std::vector<Candidate> robots;
    std::vector<Circle> refused;
    double votes = 0;
    bool convincing = false;  // no other size need be tried
  };

  // `proposed`: by edges.
  OfSize of_size(double diameter_px, std::vector<Candidate> proposed);
  // Those and what the net sees besides, each with its probability.
  std::vector<Candidate> looked_at(std::vector<Candidate> proposed, double r_px);
  // Of what the net sees at every size, which it adds to `finds`, the sizes with most evidence.
  std::vector<SizeEvidence> sizes_of_net(std::vector<NetFind>& finds);
  // The probability of the likeliest of them at about that size, by a close look.
  double best_look(const std::vector<NetFind>& finds, double r_px);
  // The likeliest circle where the net sees a robot: one that edges have there, or else the net's own.
  Candidate measured(const NetFind& find, const Likeness& others);

  const DetectorSettings& settings_;
  BodySearch& bodies_;
  SearchNet net_;
  LookNet look_net_;
  cv::Mat bgr_;
  OfSize last_;
};

}  // namespace arkmesh::tracker
