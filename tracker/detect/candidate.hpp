// Which edges are robots': each by itself, and then against what the others in the same view look like.
#pragma once

#include <vector>

#include "tracker/detect/circle_fit.hpp"
#include "tracker/detect/explanation.hpp"
#include "tracker/detect/search_net.hpp"

namespace arkmesh::tracker {

// A edge and how much it looks like a robot's.
struct Candidate {
  CircleFit circle_fit;
  double weber = 0;     // step over the edge, as a part of the brighter side
  double activity = 0;  // how much the grey level varies within, as a part of the difference to the outside
  double shape = 0;     // 0..1: how closed and round the edge is
  double likeness = 0;  // 0..1: what is inside is like a robot's board and coin cell
  double clear = 0;     // 0..1: how surely there are robots in the view if this is seen: not for each robot to reach
  double evidence = 0;  // 0..1, of this edge alone: its shape, its step and what is inside together
  bool operator<(const Candidate& other) const;  // stronger first; ties by place
};

Candidate candidate(const CircleFit& circle_fit);

// What the robots of one view have in common.
struct Likeness {
  double r_px = 0;                  // at the picture's origin ...
  double r_per_x = 0, r_per_y = 0;  // ... and how it drifts over the view, px per px
  double weber = 0, activity = 0;   // medians
  bool darker = true;
  double r_at(double x_px, double y_px) const { return r_px + r_per_x * x_px + r_per_y * y_px; }
};

// Robots of one view are about the same size: the radii that strong candidates name, the one with most evidence first.
std::vector<SizeEvidence> size_evidence(std::vector<Candidate> candidates, int width_px, int height_px);

// The same of what the net sees.
std::vector<SizeEvidence> size_evidence(std::vector<NetFind> finds, int width_px, int height_px);

// From candidates whose radius differs from r_px by at most the given part of it.
Likeness likeness(const std::vector<Candidate>& candidates, double r_px, double tolerance);

struct Judgement {
  double confidence;      // 0..1 that it is a robot among robots like these
  const char* objection;  // what speaks most against it
};
Judgement judgement(const Candidate& candidate, const Likeness& others, double tolerance);

// The probability, before a close look, that it is a robot among robots like these, where the net sees that. It was
// fitted where 0.85 of what was looked at were robots, and is taken for pictures where 0.7 are: faint robots are rather
// believed than missed.
double confidence(const Candidate& candidate, const Likeness& others, double tolerance, const NetFind& find);

// Circles by place, so that neighbours are found without looking at all of them.
class Places {
 public:
  Places(double cell_px, int width_px, int height_px);
  void add(const Circle& circle);
  // Whether a circle already added has its centre nearer than `min_px`, which is at most the size of a cell.
  bool taken(const Circle& circle, double min_px) const;

 private:
  int column(double x_px) const;
  int line(double y_px) const;
  std::size_t cell(int x, int y) const;
  double cell_px_;
  int wide_, high_;
  std::vector<std::vector<Circle>> cells_;
};

}  // namespace arkmesh::tracker
