// A circle in pixels of a picture.
#pragma once

namespace arkmesh::tracker {

struct Circle {
  double x_px = 0, y_px = 0, r_px = 0;
};

}  // namespace arkmesh::tracker
