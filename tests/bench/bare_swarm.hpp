// The least that a simulator of moving and talking robots can cost: kinematics, grid and messages, nothing else. No
// contacts, no programs, no order that has to repeat. A reference for speed.
#pragma once

#include <cstdint>
#include <memory>

namespace arkmesh::bench {

class BareSwarm {
 public:
  BareSwarm(int robots, float side_m);
  ~BareSwarm();
  void step();                     // 1/32 s
  std::uint64_t messages() const;  // received so far

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arkmesh::bench
