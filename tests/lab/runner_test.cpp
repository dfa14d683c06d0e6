// The runner's phases.
#include <bit>
#include <fstream>
#include <iterator>
#include <optional>

#include "hal/arenas/messages.hpp"
#include "lab/exchange/world_message.hpp"
#include "lab/result.hpp"
#include "tests/lab/runner_bench.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using lab::Runner;
using tests::Bench;

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
  CHECK(statuses == 3);
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
          "a breaks its own rules at period 1: " + c.what + "; correct the scenario or its declarations");
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
    bench->tell(fleet_command_t::run);
    bench->step();
    CHECK(bench->arena.robots().commands == std::vector{hal::FleetCommand::Kind::run, hal::FleetCommand::Kind::pause});
    CHECK(bench->arena.ends > 0);
  }
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

TEST_CASE("an operator's command reaches the robots") {
  Bench bench;
  while (bench.runner.period() == 0) bench.step();
  bench.step();
  bench.tell(fleet_command_t::pause);
  bench.step();
  CHECK(bench.arena.robots().commands == std::vector{hal::FleetCommand::Kind::run, hal::FleetCommand::Kind::pause});
  CHECK(bench.runner.drops()["operator.commands"] == 1);
}

TEST_CASE("what an operator says before the experiment begins stands when it begins, and never begins it") {
  using FleetKind = hal::FleetCommand::Kind;
  for (const std::uint8_t said : {fleet_command_t::pause, fleet_command_t::run}) {
    Bench bench;
    bench.arena.late = 3;
    bench.step();
    bench.tell(said);
    while (bench.arena.late > 0) bench.step();
    const std::vector<FleetKind> early = bench.arena.robots().commands;
    CHECK(std::ranges::count(early, FleetKind::run) == 0);
    while (bench.runner.period() == 0) bench.step();
    bench.step();
    const bool runs = said == fleet_command_t::run;
    CHECK(std::ranges::count(bench.arena.robots().commands, FleetKind::run) == (runs ? 1 : 0));
    if (runs) continue;
    bench.tell(fleet_command_t::run);
    bench.step();
    CHECK(bench.arena.robots().commands.back() == FleetKind::run);
  }
}

TEST_CASE("quick words of an operator leave the last one, and the end outlasts them all") {
  using FleetKind = hal::FleetCommand::Kind;
  Bench bench;
  while (bench.runner.period() == 0) bench.step();
  bench.step();
  for (int i = 0; i < 40; ++i) {
    CHECK(bench.runner.perform(fleet_command_t::pause).empty());
    CHECK(bench.runner.perform(fleet_command_t::run).empty());
  }
  bench.step();
  CHECK(bench.runner.robot_book().wanted() == FleetKind::run);
  CHECK(bench.runner.perform(operator_command_t::stop).empty());
  bench.run();
  CHECK(bench.arena.robots().commands.back() == FleetKind::pause);
  CHECK(bench.runner.robot_book().kept_still_by() == "end");
}

TEST_CASE("a word that was told once is told again after a reset, and when robots run again") {
  // By the lab itself: the scenario asks for it in one frame only. What it says is said once.
  lab::RunConfig config = tests::config_of_one_lab();
  config.last_period = 80;
  Bench bench(config);
  bench.scenario.tells_at = 3;
  const auto told = [&](hal::LabTime until) {
    while (bench.runner.lab().now() < until) bench.step();
    return std::ranges::count(bench.arena.robots().offered, 7, &hal::ToRobot::kind);
  };
  CHECK(told(2s) == 1);
  CHECK(bench.runner.perform(fleet_command_t::reset).empty());
  CHECK(told(8s) == 4);
  CHECK(bench.runner.perform(fleet_command_t::run).empty());
  CHECK(told(19s) == 7);
  CHECK(bench.runner.drops()["to_robots.told_again"] == 6);
}

TEST_CASE("a run has ended when its arena has, and says who was not seen to stand") {
  Bench bench;
  bench.arena.ends_after = 50;
  bench.step();
  bench.runner.stop("stopped by the operator");
  bench.arena.seen_to_walk = {{.robot = 1, .why = hal::NotStanding::Why::moving}};
  bench.run();
  CHECK(bench.arena.ends == 51);
  CHECK(bench.state_heard == "stopped by the operator; robots were told to stop; not seen standing: 1 (moving)");
  CHECK(bench.runner.phase() == lab_status_t::ended);
  CHECK(bench.runner.outcome_code() == lab_status_t::stopped);
}

TEST_CASE("an arena that fails again and again while the run ends costs no result") {
  Bench bench;
  bench.step();
  bench.runner.stop("stopped by the operator");
  bench.arena.gone = true;
  CHECK_NOTHROW(bench.run());
  CHECK(bench.runner.outcome() == "stopped");
  CHECK(bench.runner.phase() == lab_status_t::ended);
}

TEST_CASE("nobody commands robots on the lab's own bus") {
  Bench bench;
  bench.key.make(), bench.key.read();
  bench.bus.publish("operator_command", tests::command_for_a(bench.key, fleet_command_t::pause, 1));
  bench.bus.publish("operator_command", hal::to_message(hal::FleetCommand{.kind = hal::FleetCommand::Kind::pause}, {}));
  bench.step();
  CHECK(bench.arena.robots().commands.empty());
}

TEST_CASE("the status says that robots are paused by command") {
  Bench bench;
  while (bench.runner.period() == 0) bench.step();
  bench.step();
  CHECK(bench.runner.state_text() == "running");
  bench.tell(fleet_command_t::pause);
  bench.step();
  CHECK(bench.runner.state_text() == "running, with its robots paused by the operator");
  bench.tell(fleet_command_t::run);
  bench.step();
  CHECK(bench.runner.state_text() == "running");
}

TEST_CASE("an operator is answered at once, and no crowd of them fills the bus") {
  lab::RunConfig config = tests::config_of_one_lab();
  config.last_period = 10'000;
  Bench bench(config);
  int said = 0;
  const auto statuses = bench.bus.subscribe("status", [&](std::string_view, auto) { ++said; });
  std::vector<operator_answer_t> answers;
  const auto answered = bench.bus.subscribe(
      lab::answer_channel, [&](std::string_view, auto bytes) { REQUIRE(hal::decode(bytes, answers.emplace_back())); });
  while (bench.runner.period() == 0) bench.step();
  const auto until_said = [&](int more) {
    const int before = said;
    for (const auto from = bench.now; said < before + more && bench.now - from < 900ms;) bench.step();
    return said - before;
  };
  bench.runner.hear_command(lab::operator_channel, tests::encoded(lab::question()));
  const auto asked = bench.now;
  CHECK(until_said(1) == 1);
  CHECK(bench.now - asked <= 60ms);
  bench.tell(fleet_command_t::pause);
  const auto told = bench.now;
  CHECK(until_said(1) == 1);
  REQUIRE(answers.size() == 2);
  CHECK(answers[0].number == 0);
  CHECK(answers[0].clock_us >= bench.now.count() - 200'000);
  CHECK(answers[1].number != 0);
  CHECK(answers[1].refusal.empty());
  CHECK(bench.now - told <= 60ms);
  CHECK(bench.state_heard.find("paused by the operator") != std::string::npos);
  const int before = said;
  for (int i = 0; i < 500; ++i) bench.tell(fleet_command_t::pause), bench.step();
  CHECK(said - before <= 12);
  CHECK(answers.size() <= 2 + 12 * 8);
}

TEST_CASE("an operator ends the run with its results") {
  Bench bench;
  bench.step();
  bench.tell(operator_command_t::stop);
  bench.run();
  CHECK(bench.runner.outcome() == "stopped");
  CHECK(bench.runner.reason() == "stopped by the operator");
}

TEST_CASE("a result lists every counter once, and as drops exactly the losses") {
  // The arena's and both buses' counters have one prefix each. No word inside another one makes a loss.
  Bench bench;
  hal::Bus public_bus("memq://");
  bench.runner.count(&public_bus);
  const std::string too_long(100, 'c');
  bench.bus.publish(too_long, {});
  public_bus.publish(too_long, {});
  for (const char* name :
       {"late", "contacts.deeper_than_1mm", "camera.isolated", "mjpeg.skipped", "poses.lost.no_picture"})
    bench.arena.count(name);
  lab::Traffic met;
  met.version = "1.2.3";
  const nlohmann::json result =
      lab::lab_result(nlohmann::json::object(), bench.runner, {}, {{"roark", met}, {"lynx", lab::Traffic()}});
  CHECK(result.at("peers") == nlohmann::json{{"roark", {{"version", "1.2.3"}}}});
  for (const auto& [name, n] : result.at("drops").items()) CHECK(result.at("counters").at(name) == n);
  CHECK(result.at("counters").at("arena.contacts.deeper_than_1mm") == 1);
  std::vector<std::string> drops;
  for (const auto& [name, n] : result.at("drops").items()) drops.push_back(name);
  CHECK(drops == std::vector<std::string>{"arena.late", "arena.mjpeg.skipped", "arena.poses.lost.no_picture",
                                          "bus.refused.channel_name", "public_bus.refused.channel_name"});
}
