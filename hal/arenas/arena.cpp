// Waiting for arenas, written once.
#include "hal/arenas/arena.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <stdexcept>

namespace arkmesh::hal {

void wait_for_service(const Arena& arena, WallTime& wall) {
  constexpr std::chrono::milliseconds at_most{20};
  wall.wait_until(std::min(arena.next_service(), wall.now() + at_most));
}

std::string stopped(std::string_view why, const Arena& arena) {
  const std::string wanted = arena.waiting_for();
  return wanted.empty() ? std::string(why) : fmt::format("{}; waited for {}", why, wanted);
}

void advance(Arena& arena, LabTime t, StopRequest& stop, WallTime& wall) {
  constexpr std::chrono::seconds say_again_after{5};
  TimePoint say_at = wall.now() + say_again_after;
  while (!arena.advance_to(t)) {
    if (stop.stopped()) throw std::runtime_error(stopped("stopped by the operator", arena));
    if (const std::string wanted = arena.waiting_for(); !wanted.empty() && wall.now() >= say_at) {
      say_at = wall.now() + say_again_after;
      spdlog::info("waiting for {}", wanted);
    }
    wait_for_service(arena, wall);
    arena.serve();
  }
}

void end(Arena& arena, WallTime& wall) {
  while (!arena.end()) {
    wait_for_service(arena, wall);
    arena.serve();
  }
}

}  // namespace arkmesh::hal
