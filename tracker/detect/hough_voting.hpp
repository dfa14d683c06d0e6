// Where in a picture round things of a certain size could be: each edge pixel votes for the centres it could belong to.
// Coarse (one pixel of the downsampled image) and generous; every candidate is to be looked at closely afterwards.
#pragma once

#include <cstdint>
#include <vector>

#include "tracker/detect/downsampled_image.hpp"

namespace arkmesh::tracker {

struct CircleVote {
  double x = 0, y = 0;  // in pixels of the downsampled image
  double r = 0;         // middle of the radii that were voted for
  bool darker = true;   // than what surrounds it
  float votes = 0;      // part of the circle's edge pixels that voted, about 1 for a clean disc
};

class HoughVoting {
 public:
  // Finds the edges of a picture. An edge is at least `min_step` grey levels a pixel strong.
  void look_at(const DownsampledImage& picture, double min_step);
  // Adds the candidates with radii in [min_r, max_r] and at least `min_votes`, strongest first.
  void find(double min_r, double max_r, bool darker, double min_votes, std::vector<CircleVote>& found);

 private:
  struct Edge {
    std::int32_t x, y;
    float towards_x, towards_y;  // unit vector from dark to bright
  };
  int width_ = 0, height_ = 0;
  std::vector<Edge> edges_;
  std::vector<std::int16_t> step_x_, step_y_;
  std::vector<std::uint16_t> votes_, smooth_;
};

}  // namespace arkmesh::tracker
