// Robots that speak Aseba as an arena: they stand and run as told, hear words, say things, and whoever does not is
// named.
#include "hal/platforms/aseba/aseba_arena.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <utility>

#include "hal/arenas/robot_words.hpp"
#include "hal/platforms/aseba/aseba_link.hpp"
#include "tests/support/aseba/scripted_eyes.hpp"
#include "tests/support/aseba/scripted_node.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::aseba;
using namespace arkmesh::tests;
using namespace std::chrono_literals;
using hal::LabTime;
using Kind = hal::FleetCommand::Kind;

namespace {

struct ArenaBench {
  PassingTime wall;
  std::shared_ptr<ScriptedLine> line = std::make_shared<ScriptedLine>(wall);
  std::shared_ptr<ScriptedSight> sight = std::make_shared<ScriptedSight>();
  std::unique_ptr<hal::Arena> arena;
  LabTime now{0};

  explicit ArenaBench(const std::string& keys = "") {
    const hal::Config config = hal::Config::from_text(
        "[arena]\nrobots = 3\nwidth_m = 1.2\n[arena.aseba]\nconnect = \"tcp:127.0.0.1:1\"\n" + keys, "");
    const AsebaSettings settings = read_aseba_settings(config.root().section("arena"), "lab");
    sight->robots = settings.info.robots;
    for (const std::uint16_t number : std::initializer_list<std::uint16_t>{1, 2, 3})
      line->nodes.push_back({.number = number});
    std::vector<Connection> connections;
    connections.push_back({"the line", {}, std::make_unique<ScriptedStream>(line)});
    arena = make_aseba_arena(settings, std::move(connections), std::make_unique<ScriptedEyes>(sight), wall);
  }
  void pass(LabTime time) {
    for (const LabTime end = now + time; now < end;) {
      now += LabTime{100'000};
      hal::advance(*arena, now, hal::nobody_stops(), wall);
    }
  }
  void begin() { hal::advance(*arena, LabTime{0}, hal::nobody_stops(), wall); }
  int last_said(std::uint16_t node) { return words_of(line->node(node).events.back())[0]; }
  std::string not_standing() { return hal::in_words(arena->not_standing()); }
};

}  // namespace

TEST_CASE("aseba arena: run, pause, words and what robots say") {
  // Robots are told to stand until lab time passes, then what was commanded; words, wheels and sayings arrive.
  ArenaBench bench;
  bench.arena->robots().command({Kind::run});
  bench.begin();
  CHECK(bench.last_said(2) == 0);
  bench.pass(1s);
  CHECK(bench.last_said(2) == 1);
  CHECK(bench.arena->not_standing().empty());
  bench.line->node(2).events.clear();
  bench.arena->robots().offer(std::vector<hal::ToRobot>{{2, 0, 7, 30'000}, {2, 1, 8, 5}, hal::to_robot(3, {100, -40})});
  bench.line->say(bench.line->node(1), make_message(event_says, {4, -12}));
  bench.line->say(bench.line->node(1), make_message(17, {4, -12}));
  bench.pass(200ms);
  std::vector<std::vector<int>> words;
  for (const Message& event : bench.line->node(2).events)
    if (event.type == event_word) words.push_back(words_of(event));
  CHECK(words == std::vector<std::vector<int>>{{2, 7, 30'000}, {2, 8, 5}});
  CHECK(bench.line->node(3).at("motor.left.target") == 250);
  CHECK(bench.line->node(3).at("motor.right.target") == -100);
  const auto heard = bench.arena->robots().heard();
  REQUIRE(heard.size() == 1);
  CHECK((heard[0].robot == 1 && heard[0].kind == 4 && heard[0].value == -12));
  CHECK(bench.arena->counters()["from_robots.ignored.event"] == 1);
  bench.arena->robots().command({Kind::pause});
  bench.pass(300ms);
  CHECK(bench.last_said(3) == 0);
  CHECK(bench.line->node(3).at("motor.left.target") == 0);
  CHECK(bench.arena->not_standing().empty());
  // set points are in force again afterwards, also one that was told meanwhile, but for a reset
  bench.arena->robots().offer(std::vector<hal::ToRobot>{hal::to_robot(2, {20, 20})});
  bench.pass(200ms);
  CHECK(bench.line->node(2).at("motor.left.target") == 0);
  bench.arena->robots().command({Kind::run});
  bench.pass(200ms);
  CHECK(bench.line->node(3).at("motor.left.target") == 250);
  CHECK(bench.line->node(2).at("motor.left.target") == 50);
  bench.arena->robots().command({Kind::reset});
  bench.pass(200ms);
  bench.arena->robots().command({Kind::run});
  bench.pass(200ms);
  CHECK(bench.line->node(3).at("motor.left.target") == 0);
}

TEST_CASE("aseba arena: words a second") {
  // Words wait for each other, so that no more go out than their key says: 100 in a second, unless it is another
  // number.
  for (const int each_second : {100, 20}) {
    CAPTURE(each_second);
    ArenaBench bench(each_second == 100 ? "" : "words_per_s = 20\n");
    bench.arena->robots().command({Kind::run});
    bench.begin();
    bench.pass(1s);
    std::vector<hal::ToRobot> words;
    for (std::uint8_t slot = 0; slot < 250; ++slot) words.push_back({.robot = 1, .slot = slot, .kind = 1});
    bench.arena->robots().offer(words);
    bench.pass(2s);
    CHECK(bench.arena->robots().airtime().sent == doctest::Approx(2 * each_second).epsilon(0.06));
  }
}

TEST_CASE("aseba arena: stop") {
  // Within 2 s of the word all robots stand: one whose program sets its wheels again is halted, one that is late or
  // does not answer is named until it is seen to stand, and one that a camera sees move is named.
  ArenaBench bench;
  bench.begin();
  bench.arena->robots().command({Kind::run});
  bench.pass(1s);
  for (ScriptedNode& node : bench.line->nodes) node.at("motor.left.target") = 100;
  bench.line->node(1).obeys = false;
  bench.line->node(2).delay = 3s;
  bench.arena->robots().command({Kind::pause});
  bench.pass(1s);
  CHECK(bench.not_standing() == "2 (still watched)");
  CHECK(bench.line->node(1).paused);
  CHECK(bench.arena->counters()["robots.program_halted"] == 1);
  bench.pass(1s);
  for (const ScriptedNode& node : bench.line->nodes)
    CHECK(const_cast<ScriptedNode&>(node).at("motor.left.target") == 0);
  bench.pass(3s);
  CHECK(bench.not_standing().empty());
  for (int i = 0; i < 20; ++i) {
    bench.sight->x_m += 0.004;
    bench.pass(100ms);
  }
  CHECK(bench.not_standing() == "1-3 (moving)");
  bench.arena->robots().command({Kind::run});
  bench.pass(200ms);
  CHECK_FALSE(bench.line->node(1).paused);
  // nobody answers, and nobody is seen
  bench.line->plugged = false;
  bench.sight->covered = true;
  bench.arena->robots().command({Kind::pause});
  bench.pass(1s);
  CHECK(bench.not_standing() == "1-3 (not sent yet)");
  bench.sight->covered = false;
  bench.pass(3s);
  CHECK(bench.not_standing().empty());
  // a node that comes back is told, and stands
  bench.line->plugged = true;
  bench.line->node(2).delay = 0ms;
  bench.pass(2s);
  CHECK(bench.not_standing().empty());
  CHECK(bench.arena->robots().not_heard().restarted.size() == 3);
}

TEST_CASE("aseba arena: stop in each phase") {
  // Robots that drive without a program of ours stand within 2 s: while others are waited for, when told to, after a
  // reset, when they come back meanwhile, at the end, and when the arena is destroyed; also where three in ten
  // messages are lost.
  for (const std::uint64_t seed : {0, 1, 2, 3, 4}) {
    CAPTURE(seed);
    const double loss = seed > 0 ? 0.3 : 0;
    ArenaBench bench;
    bench.line->chance = {seed, "line"};
    const auto drive = [&] {
      for (ScriptedNode& node : bench.line->nodes) node.at("motor.left.target") = node.at("motor.right.target") = 100;
    };
    const auto stand = [&] {
      return std::ranges::all_of(bench.line->nodes, [](ScriptedNode& node) {
        return node.at("motor.left.target") == 0 && node.at("motor.right.target") == 0;
      });
    };
    const auto all = std::exchange(bench.sight->missing, {3});
    drive();
    for (const auto end = bench.wall.now() + 2s; bench.wall.now() < end; bench.wall.wait_until(bench.wall.now() + 10ms))
      REQUIRE_FALSE(bench.arena->advance_to(LabTime{0}));
    CHECK(stand());
    bench.sight->missing = all;
    bench.begin();
    bench.line->loss = loss;  // now that everybody is there
    bench.arena->robots().command({Kind::run});
    bench.pass(1s);
    drive();
    bench.arena->robots().command({Kind::pause});
    bench.pass(2s);
    CHECK(stand());
    bench.arena->robots().command({Kind::run});
    bench.pass(1s);
    drive();
    bench.arena->robots().command({Kind::reset});
    bench.pass(2s);
    CHECK(stand());
    bench.line->plugged = false;
    drive();
    bench.pass(1s);
    bench.line->plugged = true;
    bench.line->loss = 0;  // so that its description comes
    bench.pass(2s);
    CHECK(stand());
    bench.line->loss = loss;
    bench.arena->robots().command({Kind::run});
    bench.pass(1s);
    drive();
    if (loss > 0)
      bench.arena.reset();
    else
      hal::end(*bench.arena, bench.wall);
    CHECK(stand());
  }
}

TEST_CASE("aseba arena: robots that know when they are alone") {
  // A program that answers is seen with the colour it says, and its wheels are set again when it stopped them; of
  // others it is counted once that nothing stops them.
  ArenaBench bench;
  bench.line->node(1).here = {4, 0};
  bench.line->node(2).here = {9, 0};
  bench.begin();
  bench.arena->robots().command({Kind::run});
  bench.pass(3s);
  CHECK(bench.arena->counters()["robots.unguarded"] == 0);
  bench.pass(4s);
  CHECK(bench.arena->counters()["robots.unguarded"] == 1);
  const auto led_of = [&](std::size_t robot) { return bench.arena->poses().latest()->robots[robot].led; };
  CHECK(led_of(0) == hal::Led::blue);
  bench.pass(100ms);
  CHECK(led_of(1) == hal::Led::unknown);
  bench.arena->robots().offer(std::vector<hal::ToRobot>{hal::to_robot(1, {100, 0})});
  bench.pass(200ms);
  bench.line->node(1).at("motor.left.target") = 0;
  bench.line->node(1).here = {2, 1};
  bench.pass(600ms);
  bench.line->node(1).here = {2, 0};
  CHECK(led_of(0) == hal::Led::green);
  CHECK(bench.line->node(1).at("motor.left.target") == 250);
  // a program that answers no longer, and one that is loaded late
  bench.line->node(1).here.clear();
  bench.line->node(3).here = {0, 0};
  bench.pass(6s);
  CHECK(bench.arena->counters()["robots.unguarded"] == 2);
  CHECK(led_of(0) == hal::Led::unknown);
}

TEST_CASE("aseba arena: who is missing at the start") {
  // The wait names nodes and markers that are missing, and ends with that sentence, or begins without as many as may.
  ArenaBench bench("names_within_s = 5\n");
  bench.line->node(1).answers = false;
  bench.sight->missing = {3};
  CHECK_FALSE(bench.arena->advance_to(LabTime{0}));
  CHECK_THROWS_WITH(bench.begin(),
                    "the robots were not ready within 5 s: no node answers for robots 1; no camera sees the markers of "
                    "robots 3");
  ArenaBench fewer("names_within_s = 5\nmay_miss = 1\n");
  fewer.line->node(1).answers = false;
  fewer.sight->looks_for_picture = 3;  // when the wait is over there may be none
  fewer.begin();
  CHECK(fewer.arena->counters()["robots.missing_at_start"] == 1);
  fewer.arena->robots().offer(std::vector<hal::ToRobot>{{1, 0, 1, 1}, {2, 0, 1, 1}});
  fewer.pass(6s);
  CHECK(fewer.arena->robots().not_heard().words == std::set<hal::RobotId>{1});
  CHECK(fewer.arena->robots().airtime().sent == 1);
  // reset begins programs anew, and they wait
  fewer.arena->robots().command({Kind::run});
  fewer.pass(200ms);
  fewer.line->node(2).paused = true;
  fewer.arena->robots().command({Kind::reset});
  fewer.pass(200ms);
  CHECK_FALSE(fewer.line->node(2).paused);
  CHECK(fewer.last_said(2) == 0);
}

TEST_CASE("aseba arena: keys that are wrong") {
  // Each is refused by its key, with what to write.
  const auto refusal = [](const std::string& keys) {
    const hal::Config config = hal::Config::from_text("[arena]\nrobots = 3\nwidth_m = 1.2\n" + keys, "");
    const hal::Section arena = config.root().section("arena");
    try {
      open_connections(arena.section("aseba"), read_aseba_settings(arena, "lab"));
    } catch (const hal::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto of_connect = [&](const std::string& connect) {
    return refusal("[arena.aseba]\nconnect = \"" + connect + "\"\n");
  };
  CHECK(refusal("").find("connect") != std::string::npos);
  CHECK(of_connect(" ").find("one of its names is empty") != std::string::npos);
  CHECK(of_connect("udp:here").find("write tcp:HOST:PORT, or a device") != std::string::npos);
  CHECK(of_connect("tcp:127.0.0.1").find("write tcp://host:port") != std::string::npos);
  CHECK(of_connect("9 = tcp:127.0.0.1:1").find("\"9\" is not one of this arena's robots, which are 1 to 3") !=
        std::string::npos);
  CHECK(of_connect("tcp:127.0.0.1:1, 3 = /dev/ttyACM9").empty());
}
