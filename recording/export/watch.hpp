// Who watches an export: shown how far it is, and asked whether it is still wanted.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include "hal/progress.hpp"
#include "hal/stop_request.hpp"

namespace arkmesh::recording {

// The operator has stopped an export, which leaves nothing behind.
class Stopped : public std::runtime_error {
 public:
  Stopped() : std::runtime_error("stopped; nothing was written") {}
};

class Watch {
 public:
  // `what` stands before the share that is done: "run.mcap".
  Watch(hal::Progress& progress, hal::StopRequest& stop, std::string what)
      : progress_(progress), stop_(stop), what_(std::move(what)) {}
  ~Watch() { progress_.done(); }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  // How many steps there are in all.
  void expect(std::uint64_t steps) { all_ = steps; }
  // One more message is written. Throws Stopped.
  void step() {
    if (++done_ % 2048 != 0) return;
    if (stop_.stopped()) throw Stopped();
    progress_.show(fmt::format("{}: {} %", what_, 100 * done_ / (all_ > done_ ? all_ : done_)));
  }

 private:
  hal::Progress& progress_;
  hal::StopRequest& stop_;
  std::string what_;
  std::uint64_t all_ = 0, done_ = 0;
};

}  // namespace arkmesh::recording
