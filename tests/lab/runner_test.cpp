// The runner's phases, with an arena and a scenario that only note what they are asked.
#include "lab/runner.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <bit>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "hal/messages.hpp"
#include "hal/newest_frame.hpp"
#include "lab/result.hpp"
#include "lab/world_message.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using lab::Runner;

namespace {

class NotingLink final : public hal::RobotLink {
 public:
  void offer(std::span<const hal::ToRobot> newest) override {
    offered.insert(offered.end(), newest.begin(), newest.end());
  }
  hal::Airtime airtime() const override { return {.offered = offered.size()}; }
  void command(const hal::FleetCommand& command) override { commands.push_back(command.kind); }
  std::vector<hal::FromRobot> heard() override { return std::exchange(to_hear, {}); }
  std::vector<hal::ToRobot> offered;
  std::vector<hal::FleetCommand::Kind> commands;
  std::vector<hal::FromRobot> to_hear;
};

// A frame each 100 ms with odd numbers in it; not there yet for the next `late` calls.
class SlowArena final : public hal::Arena {
 public:
  explicit SlowArena(bool can_wait = true) { info_.robots = {1}, info_.max_robot = 9, info_.can_wait = can_wait; }
  const hal::ArenaInfo& info() const override { return info_; }
  const hal::Clock& clock() const override { return clock_; }
  hal::PoseSource& poses() override { return frames_; }
  NotingLink& robots() override { return link_; }
  bool advance_to(hal::LabTime t) override {
    if (late > 0) return --late, false;
    asked.push_back(t);
    if (t >= fail_at) throw std::runtime_error("the arena fails");
    clock_.set(t);
    if (t % info_.frame_period == hal::LabTime{0})
      frames_.put({.stamp = t,
                   .number = static_cast<std::uint32_t>(t / info_.frame_period),
                   .robots = {{.robot = 1, .pose = {0.1 / 3, -1e-300, 3.14159}, .confidence = 0.3f}}});
    return true;
  }
  void serve() override {
    ++served;
    if (gone) throw std::runtime_error("the arena is gone");
  }
  hal::TimePoint next_service() const override { return late > 0 ? hal::TimePoint::max() : hal::TimePoint::min(); }
  std::string waiting_for() const override { return late > 0 && says ? "two robots" : ""; }
  bool end() override { return ++ends > 0; }
  const hal::Counters& counters() const override { return counters_; }
  void count(const char* name) { counters_.add(name); }

  int late = 0, served = 0, ends = 0;
  bool says = false, gone = false;
  hal::LabTime fail_at = hal::LabTime::max();
  std::vector<hal::LabTime> asked;

 private:
  hal::Counters counters_;
  hal::ArenaInfo info_;
  hal::OwnedClock clock_;
  hal::NewestFrame frames_{counters_};
  NotingLink link_;
};

// Notes each call, says something in each, and writes rows.
class NotingScenario final : public lab::Scenario {
 public:
  void begin(lab::Lab& lab) override {
    calls.push_back("begin");
    lab.row("table", "what", "begin");
    lab.declare({.name = "team", .length = 1, .low = 0, .high = 5});
  }
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override {
    calls.push_back(fmt::format("poses {}", frame.number));
    newest = frame;
    lab.say({.robot = 1, .kind = 1});
    lab.row("table", "what", fmt::format("poses {}", frame.number));
    if (frame.number == fail_at) throw std::runtime_error("the scenario fails");
  }
  void on_heard(lab::Lab& lab, std::span<const hal::FromRobot> messages) override {
    calls.push_back(fmt::format("heard {} of {}", messages.size(), messages[0].robot));
    lab.say({.robot = 1, .kind = 2});
  }
  void on_period(lab::Lab& lab) override {
    calls.push_back(fmt::format("period {}", lab.period()));
    for (const auto& [field, values] : publishes) lab.publish(field, values);
  }
  bool finished(const lab::Lab& lab) const override { return lab.period() == end_at; }
  std::vector<std::string> calls;
  hal::PoseFrame newest;
  std::uint32_t end_at = 1000, fail_at = 1000;                 // a period, and a frame
  std::map<std::string, std::vector<std::int64_t>> publishes;  // at each boundary, for the next state
};

lab::RunConfig config() {
  lab::RunConfig c;
  c.lab = c.owner = "a";
  c.labs = {"a"};
  c.projections["a"];
  c.period = 250ms;
  c.last_period = 2;
  return c;
}

struct Bench {
  tests::TemporaryDirectory folder;
  SlowArena arena;
  NotingScenario scenario;
  hal::Bus bus{"memq://"};
  hal::Recorder recorder{folder.path(), 0, {.log = false}};
  std::vector<std::string> channels;
  Runner runner{config(), {{"run.seed", "1"}}, arena, scenario, bus, recorder, 5};
  std::unique_ptr<hal::Bus::Subscription> all = bus.subscribe(".*", [this](std::string_view channel, auto) {
    if (channel != "status" && channel != "world" && channel != "shared") channels.emplace_back(channel);
  });
  std::string state_heard;
  std::unique_ptr<hal::Bus::Subscription> states = bus.subscribe("status", [this](std::string_view, auto bytes) {
    lab_status_t status;
    REQUIRE(hal::decode(bytes, status));
    state_heard = status.state;
  });
  std::chrono::microseconds now{0};

  Runner::Step step() { return runner.step(now += 1ms); }
  void run() {
    while (step() != Runner::Step::ended) REQUIRE(now < 10s);
  }
};

}  // namespace

TEST_CASE("a lab alone passes through its phases, frames and boundaries in time order") {
  Bench bench;
  bench.run();
  CHECK(bench.runner.finished());
  CHECK(bench.runner.state_text() == "finished");
  CHECK(bench.arena.asked == std::vector<hal::LabTime>{0ms, 100ms, 200ms, 250ms, 300ms, 400ms, 500ms});
  CHECK(bench.scenario.calls == std::vector<std::string>{"begin", "poses 0", "period 0", "poses 1", "poses 2",
                                                         "period 1", "poses 3", "poses 4", "poses 5", "period 2"});
  CHECK(bench.step() == Runner::Step::ended);
}

TEST_CASE("a scenario may finish early") {
  Bench bench;
  bench.scenario.end_at = 1;
  bench.run();
  CHECK(bench.runner.finished());
  CHECK(bench.runner.period() == 1);
}

TEST_CASE("a lab that has ended still says how it is") {
  // While its arena ends, which takes some seconds where robots are told to stop.
  Bench bench;
  bench.run();
  int statuses = 0;
  const auto heard = bench.bus.subscribe("status", [&](std::string_view, auto) { ++statuses; });
  for (int k = 0; k < 3; ++k) {
    bench.now += 1s;
    CHECK(bench.step() == Runner::Step::ended);
  }
  CHECK(statuses == 2);  // the last one has yet to be heard
}

TEST_CASE("an own state that breaks the lab's own rules ends the run before peers see it") {
  // Peers would refuse it, and wait for another one.
  struct Case {
    std::string field;
    std::vector<std::int64_t> values;
    std::string what;
  };
  for (const Case& c : {Case{"team", {6}, "field 'team' holds 6, which is not within 0 to 5"},
                        Case{"team", {1, 2}, "field 'team' has 2 values instead of 1"},
                        Case{"taem", {1}, "field 'taem' is not declared in begin()"}}) {
    Bench bench;
    bench.scenario.publishes[c.field] = c.values;
    std::uint32_t published = 0;
    const auto world = bench.bus.subscribe("world", [&](std::string_view, auto bytes) {
      lab::WorldMessage message;
      REQUIRE(lab::decode_world(bytes, message).empty());
      for (const lab::LabState& state : message.window) published = std::max(published, state.period);
    });
    bench.run();
    CHECK_FALSE(bench.runner.finished());
    CHECK(bench.runner.reason() ==
          "a breaks its own rules at period 1: " + c.what + "; correct the scenario or what it declares");
    CHECK(published == 0);
  }
}

TEST_CASE("a scenario that fails ends the run with its reason, and what it wrote before is kept") {
  Bench bench;
  bench.scenario.fail_at = 2;
  bench.run();
  CHECK_FALSE(bench.runner.finished());
  CHECK(bench.runner.reason() == "a failed at period 0: the scenario fails");
  CHECK(bench.state_heard == "failed: a failed at period 0: the scenario fails");
  CHECK(bench.arena.robots().commands == std::vector{hal::FleetCommand::Kind::run, hal::FleetCommand::Kind::pause});
  std::ifstream table(bench.folder.path() / "table.csv");
  std::string text((std::istreambuf_iterator<char>(table)), {});
  CHECK(text == "what\nbegin\nposes 0\nposes 1\nposes 2\n");
}

TEST_CASE("an arena that fails ends the run with its reason, and is asked for no more") {
  Bench bench;
  bench.arena.fail_at = 200ms;
  bench.run();
  CHECK(bench.runner.reason() == "a failed at period 0: the arena fails");
  CHECK(bench.state_heard == "failed: a failed at period 0: the arena fails");
  CHECK(bench.arena.asked == std::vector<hal::LabTime>{0ms, 100ms, 200ms});
  CHECK(bench.arena.robots().commands.back() == hal::FleetCommand::Kind::pause);
}

TEST_CASE("an arena that fails when it is served ends the run, and is left alone from the second time on") {
  Bench bench;
  bench.step();
  bench.arena.gone = true;
  bench.run();
  CHECK(bench.runner.reason() == "a failed at period 0: the arena is gone");
  CHECK(bench.arena.served == 3);
}

TEST_CASE("robots hear a pause last, however the run ends") {
  Bench finished, stopped;
  finished.run();
  while (stopped.runner.period() < 1) stopped.step();
  stopped.runner.stop("stopped by the operator");
  stopped.run();
  for (Bench* bench : {&finished, &stopped}) {
    // Nobody lets them go on afterwards.
    bench->bus.publish("operator_command",
                       hal::to_message(hal::FleetCommand{.kind = hal::FleetCommand::Kind::run}, 0ms));
    bench->step();
    CHECK(bench->arena.robots().commands == std::vector{hal::FleetCommand::Kind::run, hal::FleetCommand::Kind::pause});
    CHECK(bench->arena.ends > 0);
  }
}

TEST_CASE("an arena that is not there yet makes a lab wait, and changes nothing") {
  // The same calls reach arena and scenario as from one that is there at once, and each step serves it.
  Bench quick, slow;
  quick.run();
  slow.arena.late = 3;
  for (int i = 0; i < 3; ++i) {
    CHECK(slow.step() == Runner::Step::waiting);
    CHECK(slow.runner.awaits_arena());
    CHECK(slow.arena.served == i + 1);
  }
  CHECK(slow.scenario.calls == std::vector<std::string>{"begin"});
  CHECK(slow.step() == Runner::Step::advanced);
  CHECK_FALSE(slow.runner.awaits_arena());
  slow.arena.late = 2;
  slow.run();
  CHECK(slow.arena.asked == quick.arena.asked);
  CHECK(slow.scenario.calls == quick.scenario.calls);
  CHECK(slow.channels == quick.channels);
  CHECK(slow.runner.final_hash() == quick.runner.final_hash());
}

TEST_CASE("what an arena waits for is said, also when the operator stops the lab") {
  Bench bench;
  bench.arena.late = 100;
  bench.arena.says = true;
  CHECK(bench.step() == Runner::Step::waiting);
  CHECK(bench.runner.state_text() == "waiting for two robots");
  bench.runner.stop("stopped by the operator");
  CHECK_FALSE(bench.runner.awaits_arena());
  bench.run();
  CHECK_FALSE(bench.runner.finished());
  CHECK(bench.runner.reason() == "stopped by the operator; waited for two robots");
}

TEST_CASE("a wait for the arena is forgotten when it is over") {
  Bench bench;
  bench.arena.late = 2;
  bench.arena.says = true;
  bench.step();
  bench.arena.late = 0;
  bench.step();
  CHECK(bench.runner.state_text() == "starting");
}

TEST_CASE("what robots said comes after the frame, and both answers go out as one batch") {
  Bench bench;
  bench.step();  // frame 0
  bench.step();  // boundary 0
  bench.channels.clear();
  bench.scenario.calls.clear();
  bench.arena.robots().offered.clear();
  bench.arena.robots().to_hear = {{.robot = 7, .kind = 1, .value = 2}};
  bench.step();
  CHECK(bench.scenario.calls == std::vector<std::string>{"poses 1", "heard 1 of 7"});
  CHECK(bench.channels == std::vector<std::string>{"from_robots", "poses", "to_robots"});
  REQUIRE(bench.arena.robots().offered.size() == 2);
  CHECK(bench.arena.robots().offered[0].kind == 1);
  CHECK(bench.arena.robots().offered[1].kind == 2);
}

TEST_CASE("a pose on the bus has the bits of the one that the scenario sees") {
  // So it makes no difference that nothing is decoded from the own bus.
  Bench bench;
  std::optional<hal::PoseFrame> heard;
  const auto poses = bench.bus.subscribe("poses", [&](std::string_view, auto bytes) {
    pose_frame_t message;
    REQUIRE(hal::decode(bytes, message));
    heard = hal::from_message(message);
  });
  bench.step();
  bench.step();
  REQUIRE(heard);
  const hal::PoseFrame& seen = bench.scenario.newest;
  CHECK(heard->stamp == seen.stamp);
  CHECK(heard->number == seen.number);
  REQUIRE(heard->robots.size() == 1);
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  CHECK(bits(heard->robots[0].pose.x_m) == bits(seen.robots[0].pose.x_m));
  CHECK(bits(heard->robots[0].pose.y_m) == bits(seen.robots[0].pose.y_m));
  CHECK(bits(heard->robots[0].pose.heading_rad) == bits(seen.robots[0].pose.heading_rad));
  CHECK(heard->robots[0].confidence == seen.robots[0].confidence);
  CHECK(heard->robots[0].led == seen.robots[0].led);
}

TEST_CASE("an operator's command reaches the robots; what is none is counted") {
  Bench bench;
  bench.bus.publish("operator_command",
                    hal::to_message(hal::FleetCommand{.kind = hal::FleetCommand::Kind::pause}, 0ms));
  bench.bus.publish("operator_command", hal::to_message(hal::FleetCommand{.type = 200}, 0ms));
  bench.bus.publish("operator_command", std::as_bytes(std::span("junk")));
  bench.step();
  CHECK(bench.arena.robots().commands == std::vector<hal::FleetCommand::Kind>{hal::FleetCommand::Kind::pause});
  CHECK(bench.runner.drops()["operator.commands"] == 1);
  CHECK(bench.runner.drops()["fleet_command.refused.unknown"] == 1);
  CHECK(bench.runner.drops()["fleet_command.refused.undecodable"] == 1);
}

TEST_CASE("an operator ends the run with its results") {
  Bench bench;
  bench.step();
  fleet_command_t end{};
  end.command = lab::ArenaPort::end_run;
  bench.bus.publish("operator_command", end);
  bench.run();
  CHECK(bench.runner.outcome() == "stopped");
  CHECK(bench.runner.reason() == "stopped by the operator");
}

TEST_CASE("a result lists every counter once, and as drops exactly the losses") {
  // The arena's and both buses' counters have one prefix each. No word inside another one makes a loss.
  Bench bench;
  hal::Bus public_bus("memq://");
  bench.runner.count(public_bus);
  const std::string too_long(100, 'c');
  bench.bus.publish(too_long, {});
  public_bus.publish(too_long, {});
  for (const char* name :
       {"late", "contacts.deeper_than_1mm", "camera.isolated", "mjpeg.skipped", "poses.lost.no_picture"})
    bench.arena.count(name);
  const nlohmann::json result = lab::lab_result(nlohmann::json::object(), bench.runner, {}, {});
  for (const auto& [name, n] : result.at("drops").items()) CHECK(result.at("counters").at(name) == n);
  CHECK(result.at("counters").at("arena.contacts.deeper_than_1mm") == 1);
  std::vector<std::string> drops;
  for (const auto& [name, n] : result.at("drops").items()) drops.push_back(name);
  CHECK(drops == std::vector<std::string>{"arena.late", "arena.mjpeg.skipped", "arena.poses.lost.no_picture",
                                          "bus.refused.channel_name", "public_bus.refused.channel_name"});
}

TEST_CASE("a lab that is started first waits for an hour, and says for whom") {
  tests::TemporaryDirectory folder;
  SlowArena arena;
  NotingScenario scenario;
  hal::Bus bus("memq://");
  hal::Recorder recorder(folder.path(), 0, {.log = false});
  lab::RunConfig two = config();
  two.labs = {"a", "b"};
  two.projections["b"];
  two.patience = 2s;
  Runner runner(two, {{"run.seed", "1"}}, arena, scenario, bus, recorder, 5);
  std::chrono::microseconds now{0};
  CHECK(runner.step(now) == Runner::Step::advanced);
  while (now < 1h) CHECK(runner.step(now += 2s) == Runner::Step::waiting);
  CHECK(runner.state_text() ==
        "waiting for b: the gateway of a is silent; start it with: arkmesh gateway, until it comes or the lab is "
        "stopped");
  CHECK_FALSE(runner.awaits_arena());
  CHECK(scenario.calls == std::vector<std::string>{"begin", "poses 0"});
}

TEST_CASE("a lab whose arena is late tells its peers each second that it counts") {
  Bench bench;
  bench.arena.late = 3000;
  int worlds = 0;
  const auto heard = bench.bus.subscribe("world", [&](std::string_view, auto) { ++worlds; });
  for (int i = 0; i < 3000; ++i) {
    CHECK(bench.step() == Runner::Step::waiting);
    CHECK(bench.runner.due() - bench.now <= 1s);
  }
  CHECK(worlds == 2);
}

TEST_CASE("robots of a real-time arena stand still while a peer is lost") {
  // Lab time goes on; what the run would be worth without the peer is not called finished.
  using Kind = hal::FleetCommand::Kind;
  tests::TemporaryDirectory folder;
  SlowArena arena(false);
  NotingScenario scenario;
  hal::Bus bus("memq://");
  hal::Recorder recorder(folder.path(), 0, {.log = false});
  lab::RunConfig two = config();
  two.labs = {"a", "b"};
  two.projections["b"];
  two.last_period = 100;
  Runner runner(two, {{"run.seed", "1"}}, arena, scenario, bus, recorder, 5);
  std::chrono::microseconds now{0};
  const auto hear_b = [&](std::uint64_t run_id) {
    lab::WorldMessage m{.lab = "b", .run_id = run_id, .can_wait = false};
    m.acks["a"] = {5, -1};
    m.window.push_back({.settings = {{"run.seed", "1"}}});
    m.window[0].fields[lab::arena_rule().name] = {1'000'000, 1'000'000, 1, 9};
    bus.publish("b/world", lab::to_message(m));
  };
  // A second per step, so that lab time is of no account.
  const auto pass = [&](std::uint32_t period) {
    while (runner.period() < period && runner.step(now += 1s) != Runner::Step::ended) REQUIRE(now < 1h);
  };
  const auto operator_says = [&](Kind kind) {
    bus.publish("operator_command", hal::to_message(hal::FleetCommand{.kind = kind}, 0ms));
    runner.step(now += 1s);
  };
  std::vector<Kind> said{Kind::run};
  runner.step(now);
  hear_b(2);
  pass(2);
  said.push_back(Kind::pause);
  CHECK(arena.robots().commands == said);
  CHECK(runner.state_text().starts_with("paused without b: "));
  hear_b(3);
  runner.step(now += 1s);
  said.push_back(Kind::run);
  CHECK(arena.robots().commands == said);
  CHECK(runner.state_text() == "running");

  // The peer's return does not undo what an operator said, and no operator makes robots run without the peer.
  operator_says(Kind::pause);
  said.push_back(Kind::pause);
  pass(5);
  CHECK(runner.state_text().starts_with("paused without b: "));
  hear_b(4);
  runner.step(now += 1s);
  CHECK(runner.state_text() == "running");
  pass(8);
  CHECK(runner.state_text().starts_with("paused without b: "));
  operator_says(Kind::run);
  CHECK(arena.robots().commands == said);
  hear_b(5);
  runner.step(now += 1s);
  said.push_back(Kind::run);
  CHECK(arena.robots().commands == said);

  pass(100);
  CHECK_FALSE(runner.finished());
  CHECK(runner.reason().starts_with("a reached its last period 100 without a peer: paused without b: "));
}
