// Joins a lab's private bus with its public one: copies every private message out, and lets in only what the lab wants
// from others (`*/world`, `*/status`, `peers`). Echoes cannot form: what it let in is not copied
// out.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/bus/bus.hpp"

namespace arkmesh::hal {

class Tap {
 public:
  // Both buses outlive the tap. `inputs` are LCM channel patterns of the public bus; names without '/' that match are
  // taken too, so do not list channels that the lab itself publishes.
  Tap(Bus& private_bus, Bus& public_bus, const std::vector<std::string>& inputs);
  ~Tap();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arkmesh::hal
