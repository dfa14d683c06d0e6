// What an event loop calls as long as a handle lives: when the handle dies, no call can come.
#pragma once

#include <functional>
#include <memory>

#include "hal/event_loop.hpp"

namespace arkmesh::hal {

// Calls `ready` whenever `descriptor` is readable. The descriptor remains its owner's. The loop outlives this.
class Readable {
 public:
  Readable(EventLoop& loop, int descriptor, std::function<void()> ready);
  ~Readable();

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with the loop's next call
};

}  // namespace arkmesh::hal
