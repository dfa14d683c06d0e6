// What hal/arenas/arena.hpp promises of equal arenas: equal runs, however they are served and sliced.
#pragma once

#include <doctest/doctest.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "hal/random.hpp"
#include "tests/conformance/arena_conformance.hpp"

namespace arkmesh::tests {

// Everything that an experiment sees of one run: frames, airtime at each of them, counters at the end.
struct Seen {
  std::vector<PoseFrame> frames;
  std::vector<Airtime> airtime;
  std::map<std::string, std::uint64_t, std::less<>> counters;
};

// Runs `frames` frames, advancing by steps that `next_step` makes up, and talks to robots at each frame.
inline Seen run(Arena& arena, int frames, const std::function<LabTime()>& next_step) {
  Seen out;
  const ArenaInfo& info = arena.info();
  LabTime now{0};
  arena.robots().command({FleetCommand::Kind::run});
  for (int n = 0; n <= frames; ++n) {
    const LabTime frame_at = n * info.frame_period;
    while (now < frame_at) hal::advance(arena, now = std::min(frame_at, now + next_step()));
    hal::advance(arena, frame_at);
    auto frame = arena.poses().latest();
    REQUIRE(frame);
    std::vector<ToRobot> said;
    for (std::size_t i = 0; i < info.robots.size(); i += 2)
      said.push_back(message_to(info, i, static_cast<std::uint8_t>(n % 2), static_cast<std::uint64_t>(n) * 31 + i));
    out.airtime.push_back(offer(arena, said));
    out.frames.push_back(std::move(*frame));
  }
  out.counters = arena.counters().all();
  return out;
}

inline void check_same(const Seen& a, const Seen& b) {
  REQUIRE(a.frames.size() == b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    CAPTURE(i);
    CHECK(same(a.frames[i], b.frames[i]));
    CHECK(a.airtime[i].sent == b.airtime[i].sent);
    CHECK(a.airtime[i].replaced == b.airtime[i].replaced);
    CHECK(a.airtime[i].not_sent == b.airtime[i].not_sent);
  }
}

// Gives the same bits again, however often it is served meanwhile, and, when it can wait, however its lab time is
// sliced.
inline void check_repeatable(const ArenaRow& row) {
  if (!row.repeats) return;
  const auto once = row.make(), served = row.make();
  const int frames = static_cast<int>(LabTime{1'000'000} / once->info().frame_period);
  const LabTime period = once->info().frame_period;
  const Seen a = run(*once, frames, [&] { return period; });
  RandomStream random(7, "slices");
  const Seen b = run(*served, frames, [&] {
    for (std::uint64_t k = random.below(4); k > 0; --k) served->serve();
    return period;
  });
  check_same(a, b);
  if (!once->info().can_wait) return;
  CHECK(a.counters == b.counters);
  const auto sliced = row.make();
  const Seen c = run(*sliced, frames, [&] {
    return LabTime{1 + static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(period.count())))};
  });
  check_same(a, c);
  CHECK(a.counters == c.counters);
}

}  // namespace arkmesh::tests
