// The way a textbook builds a flat world in ODE: spheres in a hash space, each held in the plane by a plane2D joint
// whose motors drive it. A reference for speed; no programs, no messages.
#pragma once

#include <memory>

namespace arkmesh::bench {

class TextbookSwarm {
 public:
  TextbookSwarm(int robots, double side_m);
  ~TextbookSwarm();
  void step();  // 1/60 s

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arkmesh::bench
