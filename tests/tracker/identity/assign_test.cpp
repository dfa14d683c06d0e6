// Assignment of ids to simulated robots that run assign_ids.c.
#include <doctest/doctest.h>

#include <set>

#include "tests/tracker/identity/arena_swarm.hpp"
#include "tracker/identity/id_assigner.hpp"
#include "tracker/identity/identity_keeper.hpp"

using namespace arkmesh;
using tests::ArenaSwarm;
using tracker::IdAssigner;

namespace {

constexpr const char* program = "hal/platforms/kilobot/firmware/assign_ids.c";

std::vector<hal::RobotId> numbers(hal::RobotId from, std::size_t n) {
  std::vector<hal::RobotId> out(n);
  std::iota(out.begin(), out.end(), from);
  return out;
}

void run(ArenaSwarm& swarm, IdAssigner& assigner, double max_s) {
  const double begun_s = swarm.seconds();
  while (!assigner.finished() && swarm.seconds() - begun_s < max_s) {
    const auto question = assigner.question();
    assigner.on_frame(swarm.now, swarm.next_picture(question));
  }
  CHECK(assigner.finished());
}

// How many robots answer with the id that the assigner says, when somebody else asks.
std::size_t right(ArenaSwarm& swarm, const IdAssigner& assigner) {
  tracker::IdentityKeeper keeper({});
  for (const double begun_s = swarm.seconds(); !keeper.settled(3) && swarm.seconds() - begun_s < 60;) {
    const auto question = keeper.question();
    keeper.on_frame(swarm.now, swarm.next_picture(question));
  }
  std::size_t n = 0;
  for (const auto& [track, robot] : assigner.robots())
    n += robot.outcome == IdAssigner::Outcome::confirmed && keeper.robot_of(track) == *robot.given;
  return n;
}

}  // namespace

TEST_CASE("identity assignment: a hundred robots, all with the same id") {
  // Fresh from the factory, a tenth of the messages lost: each gets an id of its own, and stores it.
  ArenaSwarm swarm(
      {.program = program, .robots = 100, .ids = std::vector<std::uint16_t>(100, 65535), .ode = "overhead_loss = 0.1"});
  swarm.run();
  IdAssigner assigner({.ids = numbers(0, 100)});
  run(swarm, assigner, 120);
  MESSAGE("100 ids assigned in ", swarm.seconds(), " s");
  CHECK(right(swarm, assigner) == 100);
  std::set<hal::RobotId> ids;
  for (const auto& [track, robot] : assigner.robots()) ids.insert(*robot.given);
  CHECK(ids.size() == 100);
  CHECK(*ids.rbegin() == 99);
}

TEST_CASE("identity assignment: ids that are in use already, ids of one's own choice") {
  // Robots with ids from 0 on get ids from a list that overlaps with theirs; when half of all messages are lost too.
  ArenaSwarm swarm({.program = program, .robots = 12, .ode = "overhead_loss = 0.5"});
  swarm.run();
  IdAssigner assigner({.ids = numbers(6, 12), .session = 9});
  run(swarm, assigner, 200);
  CHECK(right(swarm, assigner) == 12);
  for (const auto& [track, robot] : assigner.robots()) CHECK(*robot.given >= 6);
  // a second time, with another session and in another order
  auto ids = numbers(0, 12);
  std::reverse(ids.begin(), ids.end());
  IdAssigner again({.ids = ids, .session = 10});
  run(swarm, again, 200);
  CHECK(right(swarm, again) == 12);
}

TEST_CASE("identity assignment: temporary ids drawn twice are drawn anew") {
  // Enough robots that some coincide by chance; only those draw again.
  ArenaSwarm swarm({.program = program, .robots = 400, .side_m = 1.6, .ode = "ir_range_m = 0.0"});
  swarm.run();
  IdAssigner assigner({.ids = numbers(0, 400)});
  run(swarm, assigner, 200);
  MESSAGE("400 ids assigned in ", swarm.seconds(), " s, ", assigner.counters()["assignment.repeated.double"],
          " robots drew twice");
  CHECK(assigner.counters()["assignment.repeated.double"] >= 2);
  CHECK(right(swarm, assigner) == 400);
}

TEST_CASE("identity assignment: silent robots, and fewer ids than robots") {
  // A dead robot does not answer, and the others have theirs; when ids run out, those who got none are told of.
  ArenaSwarm swarm({.program = program, .robots = 6});
  swarm.run();
  swarm.arena().set_power(2, false);
  IdAssigner assigner({.ids = numbers(100, 3)});
  run(swarm, assigner, 200);
  CHECK(right(swarm, assigner) == 3);
  int unread = 0, none_left = 0;
  for (const auto& [track, robot] : assigner.robots()) {
    unread += robot.outcome == IdAssigner::Outcome::unread;
    none_left += robot.outcome == IdAssigner::Outcome::no_id_left;
    CHECK((robot.outcome == IdAssigner::Outcome::unread) == (swarm.robot_of(track) == 2));
  }
  CHECK(unread == 1);
  CHECK(none_left == 2);
}

TEST_CASE("identity assignment: nobody there") {
  // An empty arena ends it, with nothing given.
  IdAssigner assigner({.ids = numbers(0, 3)});
  for (int n = 0; n < 400 && !assigner.finished(); ++n) assigner.on_frame(hal::LabTime{n * 100'000}, {});
  CHECK(assigner.finished());
  CHECK(assigner.robots().empty());
}
