// Nodes at the end of lines: found, gone, back, late, twice, of another make, and on a line that is damaged or cut.
#include "hal/platforms/aseba/nodes.hpp"

#include <doctest/doctest.h>

#include "hal/random.hpp"
#include "tests/support/aseba/scripted_node.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::aseba;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

namespace {

const Make thymio{"thymio", {"motor.left.target", "motor.right.target"}, 2.5};

struct NodesBench {
  PassingTime wall;
  hal::Counters counters;
  std::vector<std::shared_ptr<ScriptedLine>> lines;
  std::unique_ptr<Nodes> nodes;

  // A line for each list of numbers.
  explicit NodesBench(const std::vector<std::vector<std::uint16_t>>& numbers, std::vector<hal::RobotId> robots,
                      std::optional<hal::RobotId> name_of_first = {}) {
    std::vector<Connection> connections;
    for (const auto& on_line : numbers) {
      lines.push_back(std::make_shared<ScriptedLine>(wall));
      for (const std::uint16_t number : on_line) lines.back()->nodes.push_back({.number = number});
      connections.push_back({"line " + std::to_string(lines.size()), lines.size() == 1 ? name_of_first : std::nullopt,
                             std::make_unique<ScriptedStream>(lines.back())});
    }
    nodes = std::make_unique<Nodes>(std::move(connections), std::move(robots), thymio, counters);
  }
  void pass(std::chrono::milliseconds time) {
    for (auto end = wall.now() + time; wall.now() < end; wall.wait_until(wall.now() + 10ms)) nodes->poll(wall.now());
  }
};

}  // namespace

TEST_CASE("aseba nodes: found by their numbers, or by their line") {
  // Nodes on two lines are robots by their numbers; the only node of a named line is that robot, whatever its number.
  NodesBench bench({{1}, {2, 3, 9}}, {2, 3, 7}, 7);
  CHECK(bench.nodes->missing() == "no node answers for robots 2, 3, 7");
  bench.pass(1s);
  CHECK(bench.nodes->missing().empty());
  for (const hal::RobotId robot : {2, 3, 7}) CHECK(bench.nodes->is_here(robot));
  CHECK(bench.counters["nodes.found"] == 3);
  CHECK(bench.counters["nodes.refused.unknown"] == 1);
  CHECK(bench.nodes->set_wheels(7, {40, -20}));
  CHECK_FALSE(bench.nodes->set_wheels(9, {1, 1}));
  bench.nodes->tell_all(0, {1});
  bench.pass(100ms);
  CHECK(bench.lines[0]->node(1).at("motor.left.target") == 100);
  CHECK(bench.lines[0]->node(1).at("motor.right.target") == -50);
  for (const auto& line : bench.lines)
    for (const ScriptedNode& node : line->nodes) {
      REQUIRE(node.events.size() == 1);
      CHECK(words_of(node.events[0]) == std::vector<int>{1});
    }
  // the wheels are read by address, and an event comes from the robot
  bench.nodes->ask_wheels(7, bench.wall.now());
  bench.nodes->ask_wheels(2, bench.wall.now());
  bench.lines[0]->say(bench.lines[0]->node(1), make_message(2, {4, -5}));
  bench.pass(100ms);
  REQUIRE(bench.nodes->wheels(7));
  CHECK_FALSE(bench.nodes->wheels(7)->stand);
  CHECK(bench.nodes->wheels(2)->stand);
  const auto events = bench.nodes->take_events();
  REQUIRE(events.size() == 1);
  CHECK(events[0].first == 7);
  CHECK(words_of(events[0].second) == std::vector<int>{4, -5});
}

TEST_CASE("aseba nodes: dead and back") {
  // A node that is silent, or whose line is cut, is gone and told as restarted when it is back; the others stay.
  NodesBench bench({{1, 2}, {3}}, {1, 2, 3});
  bench.pass(1s);
  CHECK(bench.nodes->take_restarted().empty());
  bench.lines[0]->node(2).answers = false;
  bench.lines[1]->plugged = false;
  bench.pass(5s);
  CHECK(bench.nodes->missing() == "no node answers for robots 2, 3; there is no line");
  CHECK(bench.nodes->is_here(1));
  CHECK(bench.counters["nodes.lost"] == 2);
  CHECK(bench.counters["aseba.line_lost"] == 1);
  bench.lines[0]->node(2).answers = true;
  bench.lines[1]->plugged = true;
  bench.pass(1s);
  CHECK(bench.nodes->missing().empty());
  CHECK(bench.nodes->take_restarted() == std::set<hal::RobotId>{2, 3});
  CHECK(bench.nodes->openings() == 3);
}

TEST_CASE("aseba nodes: late") {
  // A node that answers after 3 s is found, stays, is no two nodes, and is counted.
  NodesBench bench({{1}}, {1});
  bench.lines[0]->node(1).delay = 3s;
  bench.pass(7s);
  CHECK(bench.nodes->missing().empty());
  bench.nodes->ask_wheels(1, bench.wall.now());
  bench.pass(30s);
  CHECK(bench.nodes->wheels(1));
  CHECK(bench.counters["nodes.late"] == 1);
  CHECK(bench.counters["nodes.lost"] == 0);
  CHECK(bench.counters["nodes.twice"] == 0);
}

TEST_CASE("aseba nodes: two with one number") {
  // Two nodes of one number are noticed on one line and on two; when one goes, the other is used.
  for (const bool one_line : {true, false}) {
    CAPTURE(one_line);
    NodesBench bench(
        one_line ? std::vector<std::vector<std::uint16_t>>{{1, 1}} : std::vector<std::vector<std::uint16_t>>{{1}, {1}},
        {1});
    bench.pass(2s);
    CHECK(bench.nodes->missing() == "there are two nodes for robot 1; give one another number");
    CHECK(bench.counters["nodes.twice"] == 1);
    bench.lines[0]->nodes.pop_back();
    bench.pass(20s);
    CHECK(bench.nodes->missing().empty());
  }
}

TEST_CASE("aseba nodes: a second one comes late") {
  // Answers that a line lost before do not hide that there are two now.
  NodesBench bench({{1}}, {1});
  for (int i = 0; i < 50; ++i) {
    bench.lines[0]->node(1).answers = false;
    bench.pass(3s);
    bench.lines[0]->node(1).answers = true;
    bench.pass(1s);
  }
  CHECK_FALSE(bench.nodes->is_twice(1));
  bench.lines[0]->nodes.push_back({.number = 1});
  bench.pass(7s);
  CHECK(bench.nodes->is_twice(1));
}

TEST_CASE("aseba nodes: a switch that hung") {
  // Nodes that answer all questions of the last minute at once are no two; a second one is noticed afterwards.
  NodesBench bench({{1}}, {1});
  bench.pass(1s);
  bench.lines[0]->hangs = true;
  bench.pass(60s);
  CHECK(bench.counters["nodes.lost"] == 1);
  bench.lines[0]->hangs = false;
  bench.pass(10s);
  CHECK(bench.nodes->missing().empty());
  CHECK(bench.counters["nodes.twice"] == 0);
  bench.lines[0]->nodes.push_back({.number = 1});
  bench.pass(7s);
  CHECK(bench.nodes->is_twice(1));
}

TEST_CASE("aseba nodes: another program") {
  // Events of another program are counted, but for those that only ask who answers; its questions make no node two.
  NodesBench bench({{1}}, {1});
  bench.pass(1s);
  for (const RunWord word : {run_program, only_answer, stand_still})
    bench.lines[0]->raw(encode(make_message(0, {word})));
  for (int i = 0; i < 9; ++i) {
    bench.lines[0]->raw(encode(make_message(list_nodes, {protocol_version})));
    bench.lines[0]->take(make_message(list_nodes, {protocol_version}));
  }
  bench.pass(1s);
  CHECK(bench.counters["aseba.other_host"] == 2);
  CHECK_FALSE(bench.nodes->is_twice(1));
  CHECK(bench.nodes->take_events().empty());
}

TEST_CASE("aseba nodes: another make, or none that describes itself") {
  // A node without this make's wheels is refused by the variable's name; one that does not describe itself is told.
  NodesBench bench({{1, 2}}, {1, 2});
  bench.lines[0]->node(1).variables = {{"_id", 1}, {"speed.left", 1}, {"motor.right.target", 1}};
  bench.lines[0]->node(1).name = "e-puck0";
  bench.lines[0]->node(2).describes = false;
  bench.pass(2s);
  CHECK(bench.nodes->missing() ==
        "node 1 of line 1 (e-puck0) has no motor.left.target, so it is no thymio; node 2 of line 1 does not describe "
        "itself");
  CHECK(bench.counters["nodes.refused.variables"] == 1);
  CHECK_FALSE(bench.nodes->set_wheels(1, {1, 1}));
}

TEST_CASE("aseba nodes: a damaged line") {
  // A megabyte of garbage and messages cut in the middle cost no node for long, and every byte of it is counted.
  NodesBench bench({{1}}, {1});
  bench.pass(1s);
  hal::RandomStream chance(5, "garbage");
  for (int i = 0; i < 1000; ++i) {
    std::vector<std::uint8_t> garbage(1000);
    for (auto& byte : garbage) byte = static_cast<std::uint8_t>(chance.below(256));
    bench.lines[0]->raw(garbage);
  }
  bench.pass(10s);
  CHECK(bench.counters["aseba.damaged_bytes"] > 500'000);
  const auto half = encode(make_message(2, {1, 2, 3, 4}));
  bench.lines[0]->raw({half.begin(), half.begin() + 8});
  bench.pass(10ms);
  bench.lines[0]->plugged = false;
  bench.pass(500ms);
  bench.lines[0]->plugged = true;
  bench.pass(3s);
  CHECK(bench.nodes->missing().empty());
  bench.nodes->ask_wheels(1, bench.wall.now());
  bench.pass(100ms);
  CHECK(bench.nodes->wheels(1));
  // a flood of events is bounded
  for (int i = 0; i < 3000; ++i) bench.lines[0]->say(bench.lines[0]->node(1), make_message(2, {1, 2}));
  bench.pass(1s);
  CHECK(bench.nodes->take_events().size() == 1000);
  CHECK(bench.counters["from_robots.dropped.too_many"] >= 2000);
}
