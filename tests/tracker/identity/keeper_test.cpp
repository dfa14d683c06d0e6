// The book of identities, against a model of robots, air and camera.
#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "tests/tracker/identity/spelling_robots.hpp"
#include "tracker/identity/identity_keeper.hpp"

using namespace arkmesh;
using namespace arkmesh::tracker;
using namespace std::chrono_literals;

namespace {

// What a watch does: pictures in, names and doubts handed to and fro.
struct Watch {
  Watch(SpellingRobots& seen, IdentitySettings settings) : robots(seen), keeper(std::move(settings)) {}
  void look() {
    keeper.on_frame(robots.now, robots.next_picture(keeper.question()));
    for (const Naming& naming : keeper.take_namings()) {
      for (auto& robot : robots.robots)
        if (robot.track == naming.track) {
          robot.named = naming.robot;
          robot.doubtful = false;
          wrong += robot.id != naming.robot;
        }
    }
  }
  // Looks until everybody is named; at most so long. Returns the seconds it took.
  double until_named(double max_s) {
    const double begun = robots.seconds();
    while (!keeper.everybody_named() && robots.seconds() - begun < max_s) look();
    return robots.seconds() - begun;
  }
  void look_for(double s) {
    for (const double end = robots.seconds() + s; robots.seconds() < end;) look();
  }
  bool right(hal::RobotId id) { return keeper.robot_of(robots.by_id(id).track) == id; }
  bool doubted(hal::RobotId id) const { return std::ranges::binary_search(keeper.doubtful(), id); }

  SpellingRobots& robots;
  IdentityKeeper keeper;
  int wrong = 0;  // names that were not the robot's
};

}  // namespace

TEST_CASE("identity: a thousand robots in less than 25 s") {
  // With lost messages, LEDs unseen or mistaken, and cameras of 10 and 15 pictures a second and 100 or 200 ms of
  // latency; no name is wrong.
  const Conditions cases[] = {
      {.latency = 100ms},
      {.loss = 0.1, .latency = 200ms},
      {.loss = 0.1, .unseen = 0.05, .wrong = 0.01, .latency = 200ms},
      {.loss = 0.2, .unseen = 0.1, .wrong = 0.02, .latency = 150ms, .frame = 66'667us, .spacing = 55ms}};
  for (const Conditions& conditions : cases)
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      SpellingRobots robots(ids_from_0(1000), conditions, seed);
      Watch watch(robots, {.expected = ids_from_0(1000)});
      const double took_s = watch.until_named(60);
      MESSAGE("1000 robots, loss ", conditions.loss, ", LEDs unseen ", conditions.unseen, ", wrong ", conditions.wrong,
              ": ", took_s, " s, ", watch.keeper.progress().passes, " rounds of questions");
      CHECK(watch.keeper.everybody_named());
      CHECK(took_s < 25);
      CHECK(watch.wrong == 0);
    }
}

TEST_CASE("identity: ids that nobody told") {
  // Any ids, erased ones apart: those up to 1022 in the first round, longer ones in a later round with all digits.
  SpellingRobots robots({7, 1022, 0, 500, 40000, 65534}, {.loss = 0.1, .unseen = 0.05});
  Watch watch(robots, {});
  watch.until_named(60);
  CHECK(watch.keeper.everybody_named());
  for (hal::RobotId id : {7u, 1022u, 0u, 500u, 40000u, 65534u}) CHECK(watch.right(id));
  CHECK(watch.wrong == 0);
}

TEST_CASE("identity: silent robots, strangers and doubles") {
  // Everybody else is named at once; the silent are missed, the stranger and the double id are told of, and questions
  // become rare.
  auto ids = ids_from_0(20);
  ids[18] = 5;     // another 5
  ids[19] = 1000;  // not expected
  SpellingRobots robots(ids, {.loss = 0.1});
  robots.by_id(3).dark = true;
  robots.by_id(4).deaf = true;
  Watch watch(robots, {.expected = ids_from_0(20)});
  watch.look_for(60);
  for (hal::RobotId id : ids_from_0(18)) {
    const bool nameless = id == 3 || id == 4 || id == 5;
    CHECK(watch.right(id) == !nameless);
    CHECK(watch.doubted(id) == nameless);
  }
  CHECK(watch.wrong == 0);
  CHECK_FALSE(watch.keeper.everybody_named());
  CHECK(watch.keeper.settled(3));
  CHECK(std::ranges::equal(watch.keeper.strangers(), std::vector<hal::RobotId>{1000}));
  const int passes = watch.keeper.progress().passes;
  watch.look_for(120);
  CHECK(watch.keeper.progress().passes - passes <= 5);
  // The two are set apart: the newcomer gets an id of its own, and both are named.
  std::vector<SpellingRobots::Robot*> fives;
  for (auto& robot : robots.robots)
    if (robot.id == 5) fives.push_back(&robot);
  REQUIRE(fives.size() == 2);
  fives[1]->id = 18;
  watch.look_for(60);
  CHECK(watch.right(5));
  CHECK(watch.right(18));
  CHECK(watch.wrong == 0);
}

TEST_CASE("identity: double ids are told of in the round that shows them") {
  // Two robots with one id, nobody in particular expected: neither gets the name.
  SpellingRobots robots({1, 2, 2, 3}, {});
  Watch watch(robots, {});
  watch.look_for(12);
  CHECK(std::ranges::equal(watch.keeper.duplicates(), std::vector<hal::RobotId>{2}));
  CHECK(watch.right(1));
  CHECK(watch.right(3));
  CHECK(watch.wrong == 0);
}

TEST_CASE("identity: two swapped robots are asked alone and named anew") {
  // Lifted for 1.5 s, put down in each other's place under the same tracks; each is doubted all the while, both are
  // right within 20 s of being back, and no other robot is ever interrupted. The same when a tracker only suspects a
  // swap.
  for (const bool lifted : {true, false}) {
    SpellingRobots robots(ids_from_0(100), {.loss = 0.1, .unseen = 0.05, .wrong = 0.01});
    Watch watch(robots, {.expected = ids_from_0(100)});
    watch.until_named(30);
    REQUIRE(watch.keeper.everybody_named());
    watch.look_for(2);
    for (auto& robot : robots.robots) robot.answers = 0;

    auto &a = robots.by_id(17), &b = robots.by_id(80);
    if (lifted) {
      for (auto* robot : {&a, &b}) robot->hidden = true, robot->hidden_since = robots.now;
      watch.look_for(1.5);
      CHECK(watch.doubted(17));
      CHECK(watch.doubted(80));
      std::swap(a.track, b.track);
      std::swap(a.named, b.named);
      a.hidden = b.hidden = false;
    } else {
      std::swap(a.track, b.track);
      std::swap(a.named, b.named);
      a.doubtful = b.doubtful = true;
    }
    const double back_s = robots.seconds();
    while (!(watch.right(17) && watch.right(80)) && robots.seconds() - back_s < 60) {
      watch.look();
      for (hal::RobotId id : {17u, 80u}) CHECK((watch.right(id) || watch.doubted(id)));
    }
    MESSAGE("named anew after ", robots.seconds() - back_s, " s");
    CHECK(robots.seconds() - back_s < 20);
    CHECK(watch.wrong == 0);
    int interrupted = 0;
    for (const auto& robot : robots.robots) interrupted += robot.answers > 0;
    CHECK(interrupted == 2);
  }
}

TEST_CASE("identity: a doubt that turns out to be none asks nobody") {
  // A track that its tracker doubts for a moment and then not any more keeps its name; meanwhile nobody may speak to
  // it.
  SpellingRobots robots(ids_from_0(5), {});
  Watch watch(robots, {.expected = ids_from_0(5)});
  watch.until_named(30);
  watch.look_for(2);
  const int passes = watch.keeper.progress().passes;
  robots.by_id(2).doubtful = true;
  watch.look();
  CHECK(watch.doubted(2));
  CHECK_FALSE(watch.right(2));
  robots.by_id(2).doubtful = false;
  watch.look();
  CHECK(watch.right(2));
  watch.look_for(5);
  CHECK(watch.keeper.progress().passes == passes);
}

TEST_CASE("identity: many robots in doubt at once") {
  // A shadow over 8 and over 60 of 100 robots for a second: a few lists, or one round with everybody; all are right
  // again.
  for (const std::size_t covered : {8u, 60u}) {
    SpellingRobots robots(ids_from_0(100), {.loss = 0.1, .unseen = 0.05});
    Watch watch(robots, {.expected = ids_from_0(100)});
    watch.until_named(30);
    watch.look_for(2);
    for (std::size_t i = 0; i < covered; ++i)
      robots.robots[i * 100 / covered].hidden = true, robots.robots[i * 100 / covered].hidden_since = robots.now;
    watch.look_for(1.2);
    CHECK(watch.keeper.doubtful().size() == covered);
    for (auto& robot : robots.robots) robot.hidden = false;
    const double took_s = watch.until_named(60);
    MESSAGE(covered, " robots named anew in ", took_s, " s");
    CHECK(watch.keeper.everybody_named());
    CHECK(took_s < 30);
    CHECK(watch.wrong == 0);
  }
}

TEST_CASE("identity: no robots, no questions; robots that come later") {
  // An empty arena asks nobody. Robots put down one by one are named as they come.
  SpellingRobots robots({1, 2, 3}, {});
  for (auto& robot : robots.robots) robot.hidden = true, robot.hidden_since = hal::LabTime{-5'000'000};
  Watch watch(robots, {.expected = {1, 2, 3}});
  watch.look_for(5);
  CHECK_FALSE(watch.keeper.question());
  CHECK(watch.keeper.progress().passes == 0);
  for (hal::RobotId id : {2u, 1u, 3u}) {
    robots.by_id(id).hidden = false;
    watch.look_for(50);
    CHECK(watch.right(id));
  }
  CHECK(watch.keeper.everybody_named());
}

TEST_CASE("identity: whose LED is an answer") {
  // While everybody is asked, everybody's; while two are asked, theirs; afterwards nobody's.
  SpellingRobots robots(ids_from_0(4), {});
  Watch watch(robots, {.expected = ids_from_0(4)});
  watch.look_for(3);
  for (const auto& robot : robots.robots) CHECK(watch.keeper.led_is_answer(robot.track));
  watch.until_named(30);
  watch.look_for(2);
  for (const auto& robot : robots.robots) CHECK_FALSE(watch.keeper.led_is_answer(robot.track));
  robots.by_id(1).doubtful = true;
  watch.look_for(3);
  for (const auto& robot : robots.robots) CHECK(watch.keeper.led_is_answer(robot.track) == (robot.id == 1));
}

TEST_CASE("identity: robots whose LED shows in some colours only") {
  // Red cannot be seen of three robots, in whose ids other digits stand too: they are told apart by these, once only
  // they are asked; a robot that answers nothing and changes its colour once or stays as it is gets no name.
  const auto blind_to_red = [](std::vector<Track> tracks, const std::vector<TrackNumber>& blind) {
    for (Track& track : tracks)
      if (track.led == hal::Led::red && std::ranges::find(blind, track.number) != blind.end()) track.led_seen = false;
    return tracks;
  };
  SpellingRobots robots(ids_from_0(100), {.loss = 0.05});
  const std::vector<TrackNumber> blind = {robots.by_id(44).track, robots.by_id(53).track, robots.by_id(71).track};
  IdentityKeeper keeper({.expected = ids_from_0(100)});
  while (!keeper.everybody_named() && robots.seconds() < 40)
    keeper.on_frame(robots.now, blind_to_red(robots.next_picture(keeper.question()), blind));
  MESSAGE("named after ", robots.seconds(), " s");
  CHECK(keeper.everybody_named());
  for (const auto& robot : robots.robots) CHECK(keeper.robot_of(robot.track) == robot.id);

  SpellingRobots deaf({1, 2, 3, 4, 70}, {});
  for (auto& robot : deaf.robots) robot.deaf = robot.id == 70;
  IdentityKeeper other({.expected = {1, 2, 3, 4, 70}});
  while (deaf.seconds() < 120) {
    deaf.by_id(70).own = static_cast<int>(deaf.seconds()) / 3 % 2 ? hal::Led::blue : hal::Led::green;
    other.on_frame(deaf.now, deaf.next_picture(other.question()));
    CHECK_FALSE(other.robot_of(deaf.by_id(70).track));
  }
}
