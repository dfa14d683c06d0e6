// Why a search found what it found: for people, who want to know what to change.
#pragma once

#include <vector>

#include "tracker/detect/circle.hpp"
#include "tracker/detect/detection.hpp"

namespace arkmesh::tracker {

struct SizeEvidence {
  double r_px = 0;
  double votes = 0;  // a robot beyond doubt counts 1
};

struct Explanation {
  struct NotFound {
    Circle circle;
    double confidence = 0;
    const char* objection = "";
  };
  std::vector<SizeEvidence> sizes;  // the one searched for first; empty when the size was told
  bool cells_first = false;         // coin cells were taken for robots until bodies were found round them
  std::vector<NotFound> not_found;  // looked at closely, the likeliest first, none twice and none where a robot is
};

// Sorts not_found, and removes circles of another size, doubles, and those where a robot is; at most 60 stay.
void thin_out(Explanation& explanation, const std::vector<Detection>& robots);

}  // namespace arkmesh::tracker
