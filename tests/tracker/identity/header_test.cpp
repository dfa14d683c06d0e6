// arkmesh_id.h: robots say who they are, and go on as if nothing had been.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/tracker/identity/arena_swarm.hpp"
#include "tracker/identity/ark_identifier.hpp"
#include "tracker/identity/id_code.hpp"
#include "tracker/identity/identity_keeper.hpp"

using namespace arkmesh;
using tests::ArenaSwarm;
using tracker::Audience;

namespace {

void look_for(ArenaSwarm& swarm, double s, const std::optional<tracker::Question>& question = {}) {
  for (const double end = swarm.seconds() + s - 0.05; swarm.seconds() < end;) swarm.next_picture(question);
}
double moved_m(ArenaSwarm& swarm, std::size_t robot, double s, const std::optional<tracker::Question>& question = {}) {
  const hal::Pose before = swarm.seen(robot).pose;
  look_for(swarm, s, question);
  return std::hypot(swarm.seen(robot).pose.x_m - before.x_m, swarm.seen(robot).pose.y_m - before.y_m);
}
Audience list(hal::RobotId robot) {
  return {.kind = Audience::Kind::list, .robots = {robot, tracker::nobody, tracker::nobody, tracker::nobody}};
}

constexpr const char* walkers = "speed_spread = 0.0\nstart_poses = [-0.7, 0.3, 0, -0.7, 0, 0, -0.7, -0.3, 0]";

}  // namespace

TEST_CASE("identity header: digits, stillness, and afterwards everything as before") {
  // Each digit of each id is shown while the robot stands still; a robot that is not asked walks on; at the end colours
  // and motors are what they were.
  ArenaSwarm swarm({.program = "tests/sim_ode/controllers/answers.c",
                    .robots = 3,
                    .side_m = 2,
                    .ids = {5, 1022, 65534},
                    .ode = walkers});
  swarm.run();
  look_for(swarm, 2);
  for (std::size_t i = 0; i < 3; ++i) CHECK(moved_m(swarm, i, 1) > 0.005);
  for (const std::uint8_t number : tracker::digit_order(tracker::max_id_digits)) {
    look_for(swarm, 0.3, tracker::digit_question({}, number));
    for (std::size_t i = 0; i < 3; ++i) CHECK(swarm.seen(i).led == tracker::spelled(swarm.ids[i], number));
  }
  for (std::size_t i = 0; i < 3; ++i) CHECK(moved_m(swarm, i, 0.5, tracker::digit_question({}, 0)) < 1e-6);
  look_for(swarm, 0.3, tracker::end_of_questions());
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(swarm.seen(i).led == hal::Led::white);
    CHECK(moved_m(swarm, i, 1) > 0.005);
  }
  // one by name, two by range
  CHECK(moved_m(swarm, 0, 1, tracker::digit_question(list(1022), 0)) > 0.005);
  CHECK(swarm.seen(1).led == tracker::spelled(1022, 0));
  CHECK(swarm.seen(2).led == hal::Led::white);
  look_for(swarm, 0.4, tracker::digit_question({.kind = Audience::Kind::range, .robots = {6, 65535}}, 2));
  CHECK(swarm.seen(0).led == hal::Led::white);
  CHECK(swarm.seen(1).led == tracker::spelled(1022, 2));
  CHECK(swarm.seen(2).led == tracker::spelled(65534, 2));
  // who is not asked any more goes on
  CHECK(moved_m(swarm, 1, 1, tracker::digit_question(list(5), 0)) > 0.005);
  CHECK(swarm.seen(1).led == hal::Led::white);
}

TEST_CASE("identity header: the clock stands still for the program") {
  // A robot asked for 10 s changes its colour 10 s later than one that was not.
  ArenaSwarm swarm(
      {.program = "tests/sim_ode/controllers/answers.c", .robots = 3, .side_m = 2, .ids = {0, 1, 2}, .ode = walkers});
  swarm.run();
  look_for(swarm, 5);
  look_for(swarm, 10, tracker::digit_question(list(1), 3));
  look_for(swarm, 1, tracker::end_of_questions());
  double changed_at[3] = {0, 0, 0};
  while (swarm.seconds() < 60) {
    swarm.next_picture({});
    for (std::size_t i = 0; i < 3; ++i)
      if (changed_at[i] == 0 && swarm.seen(i).led == hal::Led::cyan) changed_at[i] = swarm.seconds();
  }
  // 16 ticks of difference in when they were switched on
  CHECK(std::abs(changed_at[0] - changed_at[2]) < 0.6);
  CHECK(changed_at[1] - changed_at[0] > 9.2);
  CHECK(changed_at[1] - changed_at[0] < 10.8);
}

TEST_CASE("identity header: before RUN, and when the end is not heard") {
  // An idle robot answers and does not move. Left alone a running one goes on by itself after 3 s.
  ArenaSwarm swarm(
      {.program = "tests/sim_ode/controllers/answers.c", .robots = 3, .side_m = 2, .ids = {0, 1, 2}, .ode = walkers});
  look_for(swarm, 0.5, tracker::digit_question({}, 0));
  for (std::size_t i = 0; i < 3; ++i) CHECK(swarm.seen(i).led == tracker::spelled(swarm.ids[i], 0));
  swarm.run();
  for (std::size_t i = 0; i < 3; ++i) CHECK(moved_m(swarm, i, 1, tracker::digit_question({}, 0)) < 1e-6);
  look_for(swarm, 2.5);
  for (std::size_t i = 0; i < 3; ++i) CHECK(swarm.seen(i).led == tracker::spelled(swarm.ids[i], 0));
  look_for(swarm, 1.5);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(swarm.seen(i).led == hal::Led::white);
    CHECK(moved_m(swarm, i, 1) > 0.005);
  }
}

TEST_CASE("identity header: callbacks set late, and programs that wait") {
  // A program that sets its callback in setup hears its messages and no questions; one inside delay() is stopped at
  // once.
  ArenaSwarm swarm({.program = "tests/sim_ode/controllers/answers_late.c",
                    .robots = 1,
                    .ids = {7},
                    .ode = "start_poses = [0, 0, 0]"});
  swarm.run();
  look_for(swarm, 2);
  CHECK(swarm.seen(0).led == hal::Led::white);
  look_for(swarm, 0.2, tracker::digit_question({}, 1));
  CHECK(moved_m(swarm, 0, 2, tracker::digit_question({}, 1)) < 1e-6);
  CHECK(swarm.seen(0).led == tracker::spelled(7, 1));
  look_for(swarm, 1.5, tracker::end_of_questions());
  CHECK(swarm.seen(0).led == hal::Led::white);
  CHECK(moved_m(swarm, 0, 1) > 0.001);
  swarm.broadcast({.type = 7});
  look_for(swarm, 1);
  CHECK(swarm.seen(0).led == hal::Led::magenta);
}

TEST_CASE("identity header: ARK's messages") {
  // 120 and 119: blue is the one whose id is called, red all others; 65535 ends it. Ids above 255 count whole.
  ArenaSwarm swarm({.program = "tests/sim_ode/controllers/answers.c",
                    .robots = 3,
                    .side_m = 2,
                    .ids = {5, 261, 1022},
                    .ode = walkers});
  swarm.run();
  look_for(swarm, 1);
  for (const std::uint8_t type : {tracker::ark_initial_type, tracker::ark_runtime_type}) {
    for (std::size_t called = 0; called < 3; ++called) {
      look_for(swarm, 0.3, tracker::ark_question(type, swarm.ids[called]));
      for (std::size_t i = 0; i < 3; ++i) CHECK(swarm.seen(i).led == (i == called ? hal::Led::blue : hal::Led::red));
    }
    CHECK(moved_m(swarm, 0, 1, tracker::ark_question(type, 3)) < 1e-6);
    look_for(swarm, 0.3, tracker::ark_question(type, tracker::nobody));
    for (std::size_t i = 0; i < 3; ++i) CHECK(swarm.seen(i).led == hal::Led::white);
    CHECK(moved_m(swarm, 0, 1) > 0.005);
  }
}

TEST_CASE("identity header: a hundred DHTF robots") {
  // Of whom a tenth miss each message: named in less than 15 s, the same by ARK's protocol; then two swapped by hand
  // while all walk are right within 20 s of being back, and nobody else is stopped.
  ArenaSwarm swarm({.program = "scenarios/dhtf/controller/dhtf.c", .robots = 100, .ode = "overhead_loss = 0.1"});
  swarm.run();
  look_for(swarm, 5);
  std::vector<hal::RobotId> everybody(100);
  std::iota(everybody.begin(), everybody.end(), 0u);
  tracker::IdentityKeeper keeper({.expected = everybody});
  const auto look = [&] {
    const auto question = keeper.question();
    keeper.on_frame(swarm.now, swarm.next_picture(question));
    for (const auto& naming : keeper.take_namings()) CHECK(swarm.ids[swarm.robot_of(naming.track)] == naming.robot);
  };
  const double begun_s = swarm.seconds();
  while (!keeper.everybody_named() && swarm.seconds() - begun_s < 60) look();
  MESSAGE("100 simulated robots named in ", swarm.seconds() - begun_s, " s");
  CHECK(keeper.everybody_named());
  CHECK(swarm.seconds() - begun_s < 15);
  for (int i = 0; i < 20; ++i) look();

  const std::size_t a = swarm.robot_with(11), b = swarm.robot_with(77);
  const hal::Pose at_a = swarm.seen(a).pose, at_b = swarm.seen(b).pose;
  const auto track_a = swarm.track_of[a], track_b = swarm.track_of[b];
  swarm.lift(a);
  swarm.lift(b);
  for (int i = 0; i < 12; ++i) look();
  CHECK(std::ranges::equal(keeper.doubtful(), std::vector<hal::RobotId>{11, 77}));
  // others have walked where they stood: beside the places they came from
  const auto free_near = [&](const hal::Pose& at) {
    for (double r = 0; r < 1; r += 0.005)
      for (double angle = 0; angle < 6.28; angle += 0.1) {
        const hal::Pose place{at.x_m + r * std::cos(angle), at.y_m + r * std::sin(angle), 0};
        bool is_free = std::max(std::abs(place.x_m), std::abs(place.y_m)) < 0.48;
        for (std::size_t i = 0; i < 100 && is_free; ++i)
          is_free = i == a || i == b ||
                    std::hypot(swarm.seen(i).pose.x_m - place.x_m, swarm.seen(i).pose.y_m - place.y_m) > 0.04;
        if (is_free) return place;
      }
    return at;
  };
  swarm.put(a, free_near(at_b), track_b);
  swarm.put(b, free_near(at_a), track_a);
  const double back_s = swarm.seconds();
  const auto is_right = [&](std::size_t robot) { return keeper.robot_of(swarm.track_of[robot]) == swarm.ids[robot]; };
  std::vector<bool> disturbed(100, false);
  while (!(is_right(a) && is_right(b)) && swarm.seconds() - back_s < 60) {
    look();
    for (const std::size_t robot : {a, b})
      CHECK((is_right(robot) || std::ranges::binary_search(keeper.doubtful(), swarm.ids[robot])));
    // all walk, blue, until somebody asks them
    for (std::size_t i = 0; i < 100; ++i)
      if (swarm.seen(i).led != hal::Led::blue) disturbed[i] = true;
  }
  MESSAGE("two swapped robots named anew in ", swarm.seconds() - back_s, " s");
  CHECK(swarm.seconds() - back_s < 20);
  for (std::size_t i = 0; i < 100; ++i) CHECK(disturbed[i] == (i == a || i == b));

  // ARK's protocol, all over again
  tracker::ArkIdentifier ark({.candidates = everybody});
  int named = 0;
  while (!ark.finished() && swarm.seconds() < 600) {
    ark.on_frame(swarm.now, swarm.next_picture(ark.question()));
    for (const auto& naming : ark.take_namings()) {
      CHECK(keeper.robot_of(naming.track) == naming.robot);
      ++named;
    }
  }
  CHECK(named == 100);
}
