// The register decides alone whether robots run; what it decides is told once to the arena and the bus.
#include "lab/robots/robot_book.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <vector>

#include "hal/arenas/messages.hpp"
#include "hal/random.hpp"
#include "tests/lab/runner_bench.hpp"

using namespace arkmesh;
using Kind = hal::FleetCommand::Kind;
using Who = lab::RobotBook::Who;

namespace {

struct RegisterBench {
  tests::SlowArena arena;
  hal::Bus bus{"memq://"};
  lab::RobotWords words;
  lab::RobotBook wishes{arena, bus, words, hal::LabTime{10'000'000}};

  const std::vector<Kind>& told() { return arena.robots().commands; }
  void say(Who who, Kind kind, hal::LabTime now = {}) { wishes.say(who, {.kind = kind}, now); }
};

}  // namespace

TEST_CASE("robots run only if the experiment has begun and nobody wants otherwise") {
  RegisterBench b;
  b.say(Who::operators, Kind::run);
  CHECK(b.told().empty());
  CHECK(b.wishes.kept_still_by() == "not begun");
  b.wishes.begin(hal::LabTime{0});
  CHECK(b.told() == std::vector{Kind::run});
  CHECK(b.wishes.kept_still_by().empty());
  for (const Who first : {Who::operators, Who::safety, Who::lost_peer, Who::scenario})
    for (const Who second : {Who::operators, Who::safety, Who::lost_peer, Who::scenario}) {
      if (first == second) continue;
      b.say(first, Kind::pause);
      b.say(second, Kind::pause);
      b.say(first, Kind::run);
      CHECK(b.wishes.wanted() == Kind::pause);
      b.say(second, Kind::run);
      CHECK(b.wishes.wanted() == Kind::run);
    }
  b.wishes.end(hal::LabTime{1});
  b.say(Who::operators, Kind::run);
  CHECK(b.told().back() == Kind::pause);
  CHECK(b.wishes.kept_still_by() == "end");
}

TEST_CASE("what is told last is what is wanted, after any words") {
  RegisterBench b;
  hal::RandomStream chance(1, "words");
  for (int i = 0; i < 2000; ++i) {
    const auto who = static_cast<Who>(chance.below(4));
    const Kind kind = std::vector{Kind::run, Kind::pause, Kind::sleep}[chance.below(3)];
    if (i == 500) b.wishes.begin(hal::LabTime{i});
    b.say(who, kind, hal::LabTime{i});
    CHECK((b.told().empty() ? Kind::pause : b.told().back()) == b.wishes.wanted());
  }
}

TEST_CASE("what is wanted already is told again when somebody says it, and only then") {
  RegisterBench b;
  b.wishes.begin(hal::LabTime{0});
  b.say(Who::operators, Kind::run);  // a robot was switched on anew
  CHECK(b.told() == std::vector{Kind::run, Kind::run});
  b.say(Who::safety, Kind::pause);
  b.say(Who::lost_peer, Kind::pause);
  b.say(Who::operators, Kind::run);
  CHECK(b.told() == std::vector{Kind::run, Kind::run, Kind::pause});
}

TEST_CASE("robots that rest are not woken by a pause or by the end") {
  for (const Kind rest : {Kind::sleep}) {
    RegisterBench b;
    b.wishes.begin(hal::LabTime{0});
    b.say(Who::operators, rest);
    b.say(Who::safety, Kind::pause);
    b.wishes.end(hal::LabTime{1});
    CHECK(b.told() == std::vector{Kind::run, rest});
  }
}

TEST_CASE("a reset is done once and keeps robots still until the same one lets them run") {
  RegisterBench b;
  b.wishes.begin(hal::LabTime{0});
  b.say(Who::operators, Kind::reset);
  CHECK(b.wishes.wanted() == Kind::pause);
  b.say(Who::scenario, Kind::run);
  CHECK(b.wishes.wanted() == Kind::pause);
  b.say(Who::operators, Kind::run);
  CHECK(b.told() == std::vector{Kind::run, Kind::reset, Kind::run});
}

TEST_CASE("start parameters are repeated before robots run, and again after a reset or when they change") {
  using Given = std::vector<hal::WholeMessage>;
  RegisterBench b;
  b.wishes.prepare(Given{{10, {1}}, {10, {7}}, {11, {2}}});
  b.wishes.prepare(Given{{10, {3}}});  // replaces both of its type
  b.say(Who::operators, Kind::pause);
  b.wishes.begin(hal::LabTime{0});
  CHECK(b.told() == std::vector{Kind::pause});
  const std::vector<Kind> told{8, Kind::broadcast};
  const auto and_run = [&](std::vector<Kind> before) {
    before.insert(before.end(), told.begin(), told.end());
    before.push_back(Kind::run);
    return before;
  };
  b.say(Who::operators, Kind::run);
  std::vector<Kind> all = and_run({Kind::pause});
  CHECK(b.told() == all);
  CHECK(b.arena.robots().broadcasts[0] == hal::WholeMessage{10, {3}});
  CHECK(b.arena.robots().broadcasts[1] == hal::WholeMessage{11, {2}});
  b.wishes.prepare(Given{{11, {2}}});  // no news
  b.say(Who::safety, Kind::pause);
  b.say(Who::safety, Kind::run);
  all.insert(all.end(), {Kind::pause, Kind::run});
  CHECK(b.told() == all);
  b.say(Who::operators, Kind::reset);
  b.say(Who::operators, Kind::run);
  all.push_back(Kind::reset);
  CHECK(b.told() == (all = and_run(all)));
  b.wishes.prepare(Given{{11, {4}}});
  b.say(Who::safety, Kind::pause);
  b.say(Who::safety, Kind::run);
  all.push_back(Kind::pause);
  CHECK(b.told() == and_run(all));
  b.wishes.prepare(Given(63, {12, {}}));
  CHECK(b.wishes.counters()["parameters.refused.too_many"] == 63);
}

TEST_CASE("parameters of one type for several robots are all said") {
  RegisterBench b;
  b.wishes.prepare(std::vector<hal::WholeMessage>{{10, {1, 5}}, {10, {2, 6}}});
  b.wishes.begin(hal::LabTime{0});
  REQUIRE(b.arena.robots().broadcasts.size() == 8);
  CHECK(b.arena.robots().broadcasts[0] == hal::WholeMessage{10, {1, 5}});
  CHECK(b.arena.robots().broadcasts[1] == hal::WholeMessage{10, {2, 6}});
}

TEST_CASE("what a platform does not carry is passed on to be refused, and changes nothing") {
  RegisterBench b;
  b.wishes.begin(hal::LabTime{0});
  b.say(Who::operators, Kind::charge);
  CHECK(b.wishes.wanted() == Kind::run);
}

TEST_CASE("each pause is listed with who wanted it, from when and until when") {
  RegisterBench b;
  b.say(Who::operators, Kind::pause, hal::LabTime{0});
  CHECK(b.wishes.pauses().empty());  // the experiment has not begun
  b.wishes.begin(hal::LabTime{1});
  b.say(Who::safety, Kind::pause, hal::LabTime{2});
  b.say(Who::operators, Kind::run, hal::LabTime{3});
  b.say(Who::safety, Kind::run, hal::LabTime{4});
  b.wishes.say(Who::operators, {.kind = Kind::pause}, hal::LabTime{5}, "operator of roark");
  b.wishes.say(Who::operators, {.kind = Kind::pause}, hal::LabTime{6}, "operator");
  b.wishes.end(hal::LabTime{7});
  std::vector<std::string> lines;
  for (const auto& pause : b.wishes.pauses())
    lines.push_back(
        fmt::format("{} {} {}", pause.who, pause.from.count(), pause.until.value_or(hal::LabTime{-1}).count()));
  CHECK(lines == std::vector<std::string>{"operator 1 3", "safety 2 4", "operator of roark 5 6", "operator 6 -1"});
}

namespace {

// Robots run, with one start parameter and a word each, and everything that was told is forgotten by the test.
struct RunningBench : RegisterBench {
  RunningBench() {
    wishes.prepare(std::vector<hal::WholeMessage>{{10, {1}}});
    wishes.begin({});
    for (const hal::RobotId robot : {1, 2}) words.due({}, {.robot = robot, .kind = 1}, true, second);
    arena.robots().commands.clear();
  }
  std::size_t words_due(hal::LabTime now) {
    std::size_t n = 0;
    for (const hal::RobotId robot : {1, 2}) n += words.due(now, {.robot = robot, .kind = 1}, true, second);
    return n;
  }
  // What is told when the arena says this.
  std::vector<Kind> after(hal::NotHeard lost, hal::LabTime now) {
    arena.robots().lost = std::move(lost);
    arena.robots().commands.clear();
    wishes.catch_up(now);
    return told();
  }
  void see(hal::RobotId robot, hal::LabTime now, hal::LabTime age = {}) {
    wishes.see({.stamp = now, .robots = {{.robot = robot, .age = age}}});
  }
  static constexpr hal::LabTime second{1'000'000};
};
using namespace std::chrono_literals;
const std::vector<Kind> all_again{Kind::broadcast, Kind::run};

}  // namespace

TEST_CASE(
    "after each opening of the line robots that run hear parameters, run and words again, and others before they run") {
  RunningBench b;
  CHECK(b.after({}, 1s).empty());
  CHECK(b.after({.openings = 1}, 2s) == all_again);
  CHECK(b.words_due(2s) == 2);
  CHECK(b.after({.openings = 1}, 3s).empty());
  CHECK(b.after({.openings = 2}, 4s).empty());  // a line that flaps leaves time for others
  CHECK(b.after({.openings = 2}, 7s) == all_again);
  b.say(Who::operators, Kind::pause);
  CHECK(b.after({.openings = 3}, 20s).empty());  // the arena keeps them still
  b.say(Who::operators, Kind::run);
  CHECK(b.told() == std::vector{Kind::broadcast, Kind::broadcast, Kind::broadcast, Kind::broadcast, Kind::run});
  CHECK(b.after({.openings = 3}, 30s).empty());
  CHECK(b.wishes.counters()["run.told_again"] == 2);
  CHECK(b.wishes.counters()["parameters.told_again"] == 2);
}

TEST_CASE("start parameters that did not go out are not told") {
  // They are before the next run; a broadcast of the scenario's own is never said again.
  RunningBench b;
  b.say(Who::operators, Kind::pause);
  CHECK(b.after({.broadcasts = {99}}, 1s).empty());
  b.say(Who::operators, Kind::run);
  CHECK(b.told() == std::vector{Kind::run});
  b.say(Who::operators, Kind::pause);
  CHECK(b.after({.broadcasts = {10}}, 1s).empty());
  b.say(Who::operators, Kind::run);
  CHECK(b.told().size() == 5);
  CHECK(b.after({.broadcasts = {10}}, 20s) == all_again);
}

TEST_CASE("a robot that was out of sight for long, comes late or began anew is told everything again") {
  RunningBench b;
  b.see(1, 1s);  // the first time, after the beginning
  CHECK(b.after({}, 1s) == all_again);
  b.see(1, 9s);
  b.see(1, 18s, 8s);  // not seen since
  CHECK(b.after({}, 18s).empty());
  CHECK(b.words_due(18s) == 1);
  b.see(1, 20s);
  CHECK(b.after({}, 20s) == all_again);
  CHECK(b.words_due(20s) == 1);
  CHECK(b.after({.restarted = {2}}, 30s) == all_again);
  CHECK(b.words_due(30s) == 2);
  CHECK(b.wishes.counters()["robots.seen_again"] == 2);
  CHECK(b.wishes.counters()["robots.restarted"] == 1);
}

TEST_CASE("words that were given up are told once more, those of a reset before and after robots run") {
  RunningBench b;
  CHECK(b.after({.words = {2}}, 5s).empty());
  CHECK(b.words_due(5s) == 1);
  CHECK(b.words_due(9s) == 0);
  b.say(Who::operators, Kind::reset);
  for (const auto now : {10s, 11s, 12s}) CHECK(b.words_due(now) == 2);
  CHECK(b.words_due(13s) == 0);
  b.say(Who::operators, Kind::run);
  CHECK(b.words_due(14s) == 2);
}
