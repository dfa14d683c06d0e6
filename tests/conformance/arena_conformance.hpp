// What hal/arenas/arena.hpp promises, as checks for any arena. Each takes a row of the table in arena_test.cpp. A new
// platform is done when its row passes.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/random.hpp"
#include "hal/robot/set_point.hpp"
#include "tests/support/processes/run_delay.hpp"

namespace arkmesh::tests {

using namespace hal;

struct ArenaRow {
  std::string name;
  // A new arena in its initial state; equal ones each time. It must carry at least 1 s of lab time.
  std::function<std::unique_ptr<Arena>()> make;
  // A simulator's step takes as long as its model asks for, however many robots that are: its calls are not timed.
  bool is_simulator = false;
  // Equal runs give equal frames and airtime, also where lab time is wall time.
  bool repeats = true;
  // The wall time that an arena which cannot wait keeps to, since any moment.
  std::function<std::chrono::microseconds(Arena&)> wall = [](Arena&) {
    return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now().time_since_epoch());
  };
};

inline bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

inline bool same(const PoseFrame& a, const PoseFrame& b) {
  return a.stamp == b.stamp && a.number == b.number &&
         std::equal(a.robots.begin(), a.robots.end(), b.robots.begin(), b.robots.end(),
                    [](const Observation& p, const Observation& q) {
                      return p.robot == q.robot && same_bits(p.pose.x_m, q.pose.x_m) &&
                             same_bits(p.pose.y_m, q.pose.y_m) && same_bits(p.pose.heading_rad, q.pose.heading_rad) &&
                             p.led == q.led && p.confidence == q.confidence && p.age == q.age;
                    });
}

// The same robots with the same LEDs at places that a camera's noise explains.
inline bool alike(const PoseFrame& a, const PoseFrame& b) {
  constexpr double noise_m = 0.002;
  return a.stamp == b.stamp && a.number == b.number &&
         std::equal(a.robots.begin(), a.robots.end(), b.robots.begin(), b.robots.end(),
                    [](const Observation& p, const Observation& q) {
                      return p.robot == q.robot &&
                             std::hypot(p.pose.x_m - q.pose.x_m, p.pose.y_m - q.pose.y_m) < noise_m && p.led == q.led;
                    });
}

inline std::uint64_t total(const Counters& counters) {
  std::uint64_t out = 0;
  for (const auto& [name, value] : counters.all()) out += value;
  return out;
}

// Offers, and returns the totals: every message is in exactly one place, and asking for them changes nothing.
inline Airtime offer(Arena& arena, const std::vector<ToRobot>& messages) {
  arena.robots().offer(messages);
  const auto counted = arena.counters().all();
  const Airtime air = arena.robots().airtime(), again = arena.robots().airtime();
  CHECK(air.offered == air.sent + air.replaced + air.refused + air.not_sent + air.waiting);
  CHECK(std::tie(air.offered, air.sent, air.replaced, air.refused, air.not_sent, air.waiting) ==
        std::tie(again.offered, again.sent, again.replaced, again.refused, again.not_sent, again.waiting));
  CHECK(arena.counters().all() == counted);
  return air;
}

inline ToRobot message_to(const ArenaInfo& info, std::size_t robot, std::uint8_t slot = 0, std::uint64_t content = 0) {
  return {info.robots.at(robot), slot, static_cast<std::uint8_t>(content % info.kinds),
          static_cast<std::uint32_t>(content % info.values)};
}

// The info is whole and in order.
inline void check_info(const ArenaRow& row) {
  const auto arena = row.make();
  const ArenaInfo& info = arena->info();
  CHECK(!info.name.empty());
  CHECK(!info.platform.empty());
  CHECK(info.width_m > 0);
  CHECK(info.height_m > 0);
  CHECK(info.frame_period > LabTime{0});
  CHECK(info.kinds > 0);
  CHECK(info.values > 0);
  CHECK(!info.make.empty());
  CHECK(info.body_radius_m > 0);
  CHECK(info.drive.speed_m_s > 0);
  CHECK((info.drive.wheels_apart_m > 0) == info.can_be_driven());
  CHECK(info.body_radius_m < std::min(info.width_m, info.height_m) / 2);
  REQUIRE_MESSAGE(!info.robots.empty(), "a row needs robots to check anything");
  for (std::size_t i = 1; i < info.robots.size(); ++i) CHECK(info.robots[i - 1] < info.robots[i]);
  CHECK(arena->clock().now() == LabTime{0});
}

// Frame 0 is there after advance_to(0); asking twice, or advancing to the same time again, gives nothing new.
inline void check_frame_zero(const ArenaRow& row) {
  const auto arena = row.make();
  hal::advance(*arena, LabTime{0});
  const auto frame = arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->number == 0);
  CHECK(frame->stamp == LabTime{0});
  CHECK(!arena->poses().latest());
  hal::advance(*arena, LabTime{0});
  CHECK(!arena->poses().latest());

  // what is said before lab time passes moves nobody
  const auto other = row.make();
  other->robots().offer(std::vector<ToRobot>{message_to(other->info(), 0, 0, 1)});
  other->robots().command({FleetCommand::Kind::run});
  hal::advance(*other, LabTime{0});
  const auto other_frame = other->poses().latest();
  REQUIRE(other_frame);
  CHECK((other->info().can_wait ? same(*frame, *other_frame) : alike(*frame, *other_frame)));
}

// Each frame comes at its time with its number, its robots ascending, inside the arena and in range.
inline void check_frames(const ArenaRow& row) {
  const auto arena = row.make();
  const ArenaInfo& info = arena->info();
  for (std::uint32_t n = 0; n <= 5; ++n) {
    CAPTURE(n);
    const LabTime t = n * info.frame_period;
    hal::advance(*arena, t);
    CHECK(arena->clock().now() == t);
    const auto frame = arena->poses().latest();
    REQUIRE(frame);
    CHECK(frame->number == n);
    CHECK(frame->stamp == t);
    for (std::size_t i = 0; i < frame->robots.size(); ++i) {
      const Observation& seen = frame->robots[i];
      if (i > 0) CHECK(frame->robots[i - 1].robot < seen.robot);
      CHECK(std::binary_search(info.robots.begin(), info.robots.end(), seen.robot));
      CHECK(std::abs(seen.pose.x_m) <= info.width_m / 2);
      CHECK(std::abs(seen.pose.y_m) <= info.height_m / 2);
      CHECK(seen.pose.heading_rad > -std::numbers::pi);
      CHECK(seen.pose.heading_rad <= std::numbers::pi);
      CHECK(seen.led <= Led::unknown);
      CHECK(seen.confidence >= 0);
      CHECK(seen.confidence <= 1);
      CHECK(seen.age >= LabTime{0});
    }
    CHECK(!arena->poses().latest());
  }
}

// Between two frames there is none; of several frames at once the newest is given and the others are counted.
inline void check_latest(const ArenaRow& row) {
  const auto arena = row.make();
  const LabTime period = arena->info().frame_period;
  hal::advance(*arena, LabTime{0});
  REQUIRE(arena->poses().latest());
  hal::advance(*arena, period - LabTime{1});
  CHECK(!arena->poses().latest());
  hal::advance(*arena, period);
  REQUIRE(arena->poses().latest());
  const std::uint64_t skipped_before = arena->counters()["poses.skipped"];
  hal::advance(*arena, 4 * period + period / 2);
  const auto frame = arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->number == 4);
  CHECK(frame->stamp == 4 * period);
  CHECK(arena->clock().now() == 4 * period + period / 2);
  CHECK(arena->counters()["poses.skipped"] - skipped_before == 2);
  CHECK(!arena->poses().latest());
}

// What the platform cannot carry is refused and counted; the rest is accepted.
inline void check_limits(const ArenaRow& row) {
  const auto arena = row.make();
  const ArenaInfo& info = arena->info();
  hal::advance(*arena, LabTime{0});
  const auto offer_one = [&](const ToRobot& message) {
    const std::uint64_t counted_before = total(arena->counters());
    const Airtime before = arena->robots().airtime();
    const Airtime after = offer(*arena, {message});
    CHECK(after.offered == before.offered + 1);
    const bool refused = after.refused == before.refused + 1;
    if (refused) CHECK(total(arena->counters()) > counted_before);
    return refused;
  };
  CHECK_FALSE(offer_one(message_to(info, 0)));
  ToRobot largest = message_to(info, info.robots.size() - 1);
  largest.kind = static_cast<std::uint8_t>(info.kinds - 1);
  largest.value = info.values - 1;
  CHECK_FALSE(offer_one(largest));

  for (int robot = 0; robot <= 65'535; ++robot)
    if (!std::binary_search(info.robots.begin(), info.robots.end(), robot)) {
      ToRobot unknown = message_to(info, 0);
      unknown.robot = static_cast<RobotId>(robot);
      CHECK(offer_one(unknown));
      break;
    }
  ToRobot kind = message_to(info, 0), value = message_to(info, 0);
  kind.kind = info.kinds;
  CHECK(offer_one(kind));
  value.value = info.values;
  CHECK(offer_one(value));
  // wheels may be set where there are some
  if (info.can_be_driven()) CHECK_FALSE(offer_one(to_robot(info.robots[0], SetPoint{50, -50})));
  ToRobot whole{.robot = everyone, .whole = WholeMessage{.type = 127}};
  CHECK(offer_one(whole) == (info.whole == WholeMessages::to_nobody));
  whole.robot = info.robots[0];
  CHECK(offer_one(whole) == (info.whole != WholeMessages::to_each));
  whole = {.robot = everyone, .whole = WholeMessage{.type = 128}};
  CHECK(offer_one(whole));
}

// One register per (robot, slot): the newest wins, other slots and robots are left alone, and each offer is settled
// once.
inline void check_registers(const ArenaRow& row) {
  const auto arena = row.make();
  const ArenaInfo& info = arena->info();
  hal::advance(*arena, LabTime{0});
  const Airtime first = offer(*arena, {message_to(info, 0, 0, 1)});
  CHECK(first.offered == 1);
  CHECK(first.replaced == 0);
  const Airtime second = offer(*arena, {message_to(info, 0, 0, 2)});
  CHECK(second.offered == 2);
  if (first.waiting == 1) {
    CHECK(second.replaced == 1);
    CHECK(second.waiting == 1);
  }
  const Airtime third = offer(*arena, {message_to(info, 0, 1, 3), message_to(info, info.robots.size() - 1, 0, 4)});
  CHECK(third.offered == 4);
  if (info.robots.size() > 1) CHECK(third.replaced == second.replaced);

  // the same register twice in one offer
  const Airtime fourth = offer(*arena, {message_to(info, 0, 2, 5), message_to(info, 0, 2, 6)});
  CHECK(fourth.offered == 6);
  CHECK(fourth.waiting <= third.waiting + 1);

  // with time nothing waits any more, and what was refused or replaced stays what it was
  for (int n = 1; n <= 8; ++n) hal::advance(*arena, n * info.frame_period);
  const Airtime settled = offer(*arena, {});
  CHECK(settled.offered == 6);
  CHECK(settled.waiting == 0);
  CHECK(settled.refused == 0);
  CHECK(settled.replaced == fourth.replaced);
}

// Commands that the platform carries are taken at any time, others are refused and counted by name; what is heard comes
// from known robots.
inline void check_commands(const ArenaRow& row) {
  const auto arena = row.make();
  const ArenaInfo& info = arena->info();
  hal::advance(*arena, LabTime{0});
  const auto refused = [&] {
    std::uint64_t out = 0;
    for (const auto& [name, value] : arena->counters().all())
      if (name.starts_with("fleet_command.refused.")) out += value;
    return out;
  };
  for (int kind = 0; kind <= static_cast<int>(FleetCommand::Kind::broadcast); ++kind) {
    FleetCommand command;
    command.kind = static_cast<FleetCommand::Kind>(kind);
    command.type = 120;
    command.data = {1, 2, 3};
    const std::uint64_t before = refused();
    arena->robots().command(command);
    CHECK(refused() - before == (std::ranges::count(info.commands, command.kind) > 0 ? 0 : 1));
    hal::advance(*arena, (kind + 1) * info.frame_period / 2);
    for (const FromRobot& said : arena->robots().heard())
      CHECK(std::binary_search(info.robots.begin(), info.robots.end(), said.robot));
  }
  const auto frame = arena->poses().latest();
  REQUIRE(frame);
  CHECK(frame->number == 3);
}

// What an arena gives up it tells once, and of what it carries in time it tells nothing: neither words nor broadcasts,
// but those of a flood that it refuses.
inline void check_not_heard(const ArenaRow& row) {
  const auto arena = row.make();
  const ArenaInfo& info = arena->info();
  hal::advance(*arena, LabTime{0});
  const std::uint64_t openings = arena->robots().not_heard().openings;
  const auto given_up = [&] {
    const NotHeard lost = arena->robots().not_heard();
    CHECK(lost.openings == openings);
    for (const RobotId robot : lost.words) CHECK(std::ranges::binary_search(info.robots, robot));
    return lost.broadcasts.size() + lost.words.size();
  };
  CHECK(given_up() == 0);
  arena->robots().offer(std::vector<ToRobot>{message_to(info, 0), message_to(info, 0, 1)});
  arena->robots().command({.kind = FleetCommand::Kind::broadcast, .type = 120});
  for (int n = 1; n <= 8; ++n) hal::advance(*arena, n * info.frame_period);
  CHECK(given_up() == 0);
  for (int i = 0; i < 200; ++i) arena->robots().command({.kind = FleetCommand::Kind::broadcast, .type = 121});
  CHECK(given_up() == (arena->counters()["fleet_command.refused.too_many"] > 0));
  CHECK(given_up() == 0);
}

// Robots of a program that walks stand once they were reset, and walk again when they are told to run.
inline void check_reset(const ArenaRow& row) {
  using namespace std::chrono_literals;
  const auto arena = row.make();
  LabTime now{0};
  // How far robots come in 2 s, on average, when they have had time to hear what they were told.
  const auto mean_way_m = [&](FleetCommand::Kind kind) {
    arena->robots().command({kind});
    hal::advance(*arena, now += 3s);
    const auto begin = arena->poses().latest();
    hal::advance(*arena, now += 2s);
    const auto end = arena->poses().latest();
    REQUIRE(begin);
    REQUIRE(end);
    REQUIRE(begin->robots.size() == end->robots.size());
    double sum_m = 0;
    for (std::size_t i = 0; i < begin->robots.size(); ++i) {
      const Pose &from = begin->robots[i].pose, &to = end->robots[i].pose;
      sum_m += std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
    }
    return sum_m / static_cast<double>(begin->robots.size());
  };
  CHECK(mean_way_m(FleetCommand::Kind::run) > 0.004);
  CHECK(mean_way_m(FleetCommand::Kind::reset) < 0.001);
  CHECK(mean_way_m(FleetCommand::Kind::run) > 0.004);
}

// Robots that should run are not judged. Those that are told to stand, or whose run is over, are seen to after a while,
// and it is the newest word that counts.
inline void check_standing(const ArenaRow& row) {
  using namespace std::chrono_literals;
  const auto arena = row.make();
  const ArenaInfo& info = arena->info();
  hal::advance(*arena, LabTime{0});
  arena->robots().command({FleetCommand::Kind::run});
  hal::advance(*arena, 1 * info.frame_period);
  CHECK(arena->not_standing().empty());
  arena->robots().command({FleetCommand::Kind::pause});
  arena->robots().command({FleetCommand::Kind::run});
  arena->robots().command({FleetCommand::Kind::pause});
  for (const NotStanding& robot : arena->not_standing())
    CHECK(std::binary_search(info.robots.begin(), info.robots.end(), robot.robot));
  LabTime now = info.frame_period;
  if (!info.can_wait)
    while (!arena->not_standing().empty() && now < 8s) hal::advance(*arena, now += info.frame_period);
  CHECK(arena->not_standing().empty());
  hal::end(*arena);
  CHECK(arena->not_standing().empty());
}

// No call blocks: one that is not there yet changes no lab time and says when it wants to be called again, and then it
// gets there. Nor does serve() let lab time pass, or end().
inline void check_waits_for_nobody(const ArenaRow& row) {
  using namespace std::chrono;
  const auto arena = row.make();
  int calls = 0, slow = 0;
  const auto timed = [&](const auto& call) {
    const OwnTime own;
    const auto result = call();
    ++calls;
    slow += own.passed() > milliseconds{20};
    return result;
  };
  const auto served = [&] {
    return timed([&] {
      const LabTime before = arena->clock().now();
      arena->serve();
      return arena->clock().now() == before;
    });
  };
  LabTime now{0};
  for (int n = 0; n <= 5; ++n) {
    const LabTime t = n * arena->info().frame_period;
    const auto deadline = steady_clock::now() + seconds{300};
    while (!timed([&] { return arena->advance_to(t); })) {
      CHECK_FALSE(arena->info().can_wait);
      CHECK(arena->clock().now() == now);
      REQUIRE(arena->next_service() < steady_clock::now() + seconds{1});
      REQUIRE(steady_clock::now() < deadline);
      hal::wait_for_service(*arena);
      CHECK(served());
    }
    now = t;
    CHECK(arena->clock().now() == t);
    CHECK(arena->waiting_for().empty());
    if (arena->info().can_wait) CHECK(arena->next_service() == TimePoint::max());
    for (int k = 0; k < 3; ++k) CHECK(served());
  }
  const auto begun = steady_clock::now();
  while (!timed([&] { return arena->end(); })) {
    REQUIRE(steady_clock::now() < begun + seconds{300});
    hal::wait_for_service(*arena);
  }
  CHECK(arena->end());
  CHECK(arena->clock().now() == now);
  if (!row.is_simulator) CHECK(10 * slow <= calls);
}

// An arena that cannot wait keeps to the wall clock from its first call with t > 0 on, however long that came after
// frame 0.
inline void check_pace(const ArenaRow& row) {
  const auto arena = row.make();
  if (arena->info().can_wait) return;
  hal::advance(*arena, LabTime{0});
  const auto start = row.wall(*arena);
  for (LabTime t : {LabTime{50'000}, LabTime{120'000}, LabTime{121'000}, LabTime{300'000}}) {
    hal::advance(*arena, t);
    CHECK(arena->clock().now() == t);
    CHECK(row.wall(*arena) - start >= t);
  }
  // only a bound against hanging: the machine may be busy
  CHECK(row.wall(*arena) - start < std::chrono::seconds{300});
}

}  // namespace arkmesh::tests
