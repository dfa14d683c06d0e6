// The machine's time for programs with an event loop: to wait is to serve what is on the loop. The one place where such
// a program sleeps.
#pragma once

#include <memory>

#include "hal/event_loop.hpp"
#include "hal/time/wall_time.hpp"

namespace arkmesh::hal {

class LoopTime final : public WallTime {
 public:
  // `loop` outlives this; nobody else runs it, and nobody waits from within what it calls.
  explicit LoopTime(EventLoop& loop);
  ~LoopTime() override;

  TimePoint now() override { return TimePoint::clock::now(); }
  // What is ready is served in any case.
  void wait_until(TimePoint then) override;
  // Returns at `then` at the latest, and as soon as anything was served.
  void wait_for_anything(TimePoint then);
  // What is ready now, as far as a few milliseconds go.
  void serve() { wait_for_anything(TimePoint::min()); }

 private:
  struct Alarm;
  EventLoop& loop_;
  std::unique_ptr<Alarm> alarm_;
};

}  // namespace arkmesh::hal
