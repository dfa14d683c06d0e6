// A runner that waits, for its arena or for peers.
#include <functional>

#include "lab/exchange/world_message.hpp"
#include "tests/lab/runner_bench.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using lab::Runner;
using tests::Bench;

namespace {

lab::RunConfig config_of_two_labs() {
  lab::RunConfig two = tests::config_of_one_lab();
  two.labs = {"a", "b"};
  two.projections["b"];
  return two;
}

}  // namespace

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

TEST_CASE("a scenario that computes elsewhere makes a lab wait, and changes nothing") {
  // The same calls reach arena and scenario; what it says before it has settled goes out with the rest, once.
  Bench quick, slow;
  quick.run();
  slow.scenario.computes = slow.scenario.unsettled = 2;
  CHECK(slow.step() == Runner::Step::waiting);
  CHECK(slow.runner.awaits_scenario());
  CHECK_FALSE(slow.runner.awaits_arena());
  CHECK(slow.scenario.calls == std::vector<std::string>{"begin", "poses 0"});
  CHECK(slow.arena.robots().offered.empty());
  CHECK(slow.step() == Runner::Step::waiting);
  slow.runner.await_scenario(1ms);  // settles
  CHECK(slow.arena.served == 2);
  slow.run();
  CHECK(slow.arena.asked == quick.arena.asked);
  CHECK(slow.scenario.calls == quick.scenario.calls);
  CHECK(slow.channels == quick.channels);
  CHECK(slow.runner.final_hash() == quick.runner.final_hash());
  CHECK(slow.arena.robots().offered.size() > quick.arena.robots().offered.size());
}

TEST_CASE("a lab whose scenario computes is stopped at once") {
  Bench bench;
  bench.scenario.computes = bench.scenario.unsettled = 1'000'000;
  for (int i = 0; i < 10; ++i) CHECK(bench.step() == Runner::Step::waiting);
  bench.runner.stop("stopped by the operator");
  CHECK_FALSE(bench.runner.awaits_scenario());
  bench.run();
  CHECK_FALSE(bench.runner.finished());
  CHECK(bench.arena.robots().offered.empty());
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

TEST_CASE("a lab that is started first waits for an hour, and says for whom") {
  lab::RunConfig two = config_of_two_labs();
  two.patience = 2s;
  Bench bench(two);
  Runner& runner = bench.runner;
  std::chrono::microseconds now{0};
  CHECK(runner.step(now) == Runner::Step::advanced);
  while (now < 1h) CHECK(runner.step(now += 2s) == Runner::Step::waiting);
  CHECK(runner.state_text() ==
        "waiting for b: the gateway of a is silent; start it with: arkmesh gateway, until it connects or the lab is "
        "stopped");
  CHECK_FALSE(runner.awaits_arena());
  CHECK(bench.scenario.calls == std::vector<std::string>{"begin", "poses 0"});
}

TEST_CASE("an arena that starts with the labs is not asked before they are there") {
  // What it starts would use up its time alone. The lab of a run that is over is not there yet.
  Bench bench(config_of_two_labs(), false);
  bench.arena.start_with_labs();
  std::chrono::microseconds now{0};
  const auto pass = [&](const char* state) {
    lab_status_t m{};
    m.lab = "b";
    m.nonce = 2;
    m.state = state;
    m.outcome = std::string_view(state) == "finished" ? lab_status_t::finished : lab_status_t::open;
    for (int i = 0; i < 30; ++i) {
      if (*state) bench.bus.publish("b/status", m);
      bench.runner.step(now += 100ms);
    }
  };
  pass("");
  CHECK(bench.arena.asked.empty());
  CHECK(bench.runner.state_text().starts_with("waiting for b"));
  pass("finished");
  CHECK(bench.arena.asked.empty());
  pass("waiting for a");
  CHECK(bench.arena.asked == std::vector<hal::LabTime>{0us});
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
  using FleetKind = hal::FleetCommand::Kind;
  lab::RunConfig two = config_of_two_labs();
  two.last_period = 100;
  Bench bench(two, false);
  Runner& runner = bench.runner;
  tests::SlowArena& arena = bench.arena;
  hal::Bus& bus = bench.bus;
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
  const auto operator_says = [&](FleetKind kind) {
    bench.tell(static_cast<std::uint8_t>(kind));
    runner.step(now += 1s);
  };
  std::vector<FleetKind> said{FleetKind::run};
  runner.step(now);
  hear_b(2);
  pass(2);
  said.push_back(FleetKind::pause);
  CHECK(arena.robots().commands == said);
  CHECK(runner.state_text().starts_with("paused without b: "));
  hear_b(3);
  runner.step(now += 1s);
  said.push_back(FleetKind::run);
  CHECK(arena.robots().commands == said);
  CHECK(runner.state_text() == "running");

  // The peer's return does not undo what an operator said, and no operator makes robots run without the peer.
  operator_says(FleetKind::pause);
  said.push_back(FleetKind::pause);
  pass(5);
  CHECK(runner.state_text().starts_with("paused without b: "));
  hear_b(4);
  runner.step(now += 1s);
  CHECK(runner.state_text() == "running, with its robots paused by the operator");
  pass(8);
  CHECK(runner.state_text().starts_with("paused without b: "));
  operator_says(FleetKind::run);
  CHECK(arena.robots().commands == said);
  hear_b(5);
  runner.step(now += 1s);
  said.push_back(FleetKind::run);
  CHECK(arena.robots().commands == said);

  pass(100);
  CHECK_FALSE(runner.finished());
  CHECK(runner.reason().starts_with("a reached its last period 100 without a peer: paused without b: "));
}

namespace {

// Lab a, whose peer b lives, and says its newest state again and again: nothing of it is lost.
struct NewsBench {
  explicit NewsBench(const std::function<void(lab::RunConfig&)>& change = {}, bool can_wait = false)
      : bench(
            [&] {
              lab::RunConfig two = config_of_two_labs();
              two.last_period = 100'000;
              two.period = 250ms;
              if (change) change(two);
              return two;
            }(),
            can_wait) {}
  // For so long b says the state of that period.
  void pass(std::chrono::seconds time, std::uint32_t period, std::uint64_t run_id = 2) {
    for (const auto until = now + time; now < until; now += 100ms) {
      lab::WorldMessage m{.lab = "b", .run_id = run_id, .can_wait = false};
      m.acks["a"] = {5, -1};
      m.window.push_back({.period = period});
      if (period == 0) {
        m.window[0].settings = {{"run.seed", "1"}};
        m.window[0].fields[lab::arena_rule().name] = {1'000'000, 1'000'000, 1, 9};
      }
      bench.bus.publish("b/world", lab::to_message(m));
      // As many boundaries as lab time takes.
      while (bench.runner.step(now) == Runner::Step::advanced && bench.runner.period() * 250ms < now) continue;
    }
  }
  Bench bench;
  std::chrono::microseconds now{0};
};

}  // namespace

TEST_CASE("a lab that can wait merges at each boundary what a real-time arena says at the same") {
  // It could not begin the next period sooner anyway; merged before, everything of that arena would be a period older.
  NewsBench b({}, true);
  const Runner& runner = b.bench.runner;
  b.pass(1s, 0);
  CHECK(runner.period() == 0);
  CHECK(b.bench.arena.clock().now() == 250ms);
  for (std::uint32_t k = 1; k < 5; ++k) {
    b.pass(1s, k);
    CHECK(runner.period() == k);
    CHECK(runner.lab().state("b").period == k);
  }
}

TEST_CASE("a lab that hears of the owner's end before it is there goes on to that boundary") {
  // The owner's last state is there when this lab is two boundaries behind. Ended where it is, the labs of one run
  // would not be as long as each other.
  NewsBench b([](lab::RunConfig& run) { run.owner = "b", run.last_period = 10; }, true);
  const Runner& runner = b.bench.runner;
  for (std::uint32_t k = 0; k < 5; ++k) b.pass(1s, k);
  lab::WorldMessage m{.lab = "b", .run_id = 2, .can_wait = false, .done = true};
  m.acks["a"] = {5, 4};
  for (std::uint32_t period : {5, 6, 7}) m.window.push_back({.period = period});
  b.bench.bus.publish("b/world", lab::to_message(m));
  for (int i = 0; i < 1000 && b.bench.runner.step(b.now) == Runner::Step::advanced; ++i) continue;
  CHECK(runner.period() == 7);
  CHECK(runner.last_period() == 7);
  CHECK(runner.lab().state("b").period == 7);
  CHECK(runner.outcome() == "finished");
}

TEST_CASE("a free lab that has finished stays until it has its peers' last states") {
  // The final hash is made of them. This peer has everything of ours, and is a boundary behind.
  NewsBench b([](lab::RunConfig& run) { run.owner = "a", run.last_period = 4; });
  Runner& runner = b.bench.runner;
  const auto says = [&](std::uint32_t period, bool done) {
    lab::WorldMessage m{.lab = "b", .run_id = 2, .can_wait = false, .done = done};
    m.acks["a"] = {5, 4};
    m.window.push_back({.period = period, .hash = done ? 104u : 0u});
    b.bench.bus.publish("b/world", lab::to_message(m));
    for (const auto until = b.now + 2s; b.now < until; b.now += 100ms) runner.step(b.now);
  };
  for (std::uint32_t k = 0; k < 4; ++k) b.pass(1s, k);
  for (int i = 0; i < 1000 && runner.outcome() != "finished"; ++i) runner.step(b.now += 10ms);
  CHECK(runner.period() == 4);
  says(3, false);
  CHECK_FALSE(runner.finished());
  says(4, true);
  CHECK(runner.finished());
  CHECK(runner.hash_by_lab().at("b") == 104);
}

TEST_CASE("robots of a real-time arena stand still when no new state of any peer was applied for 10 s") {
  // The peer is there all the time, and nothing of it is lost.
  using FleetKind = hal::FleetCommand::Kind;
  for (const auto on_peer_lost : {lab::RunConfig::OnPeerLost::pause, lab::RunConfig::OnPeerLost::go_on}) {
    NewsBench b([&](lab::RunConfig& run) { run.on_peer_lost = on_peer_lost; });
    Runner& runner = b.bench.runner;
    const auto& said = b.bench.arena.robots().commands;
    b.pass(9s, 0);
    CHECK(said == std::vector{FleetKind::run});
    b.pass(3s, 0);
    CHECK(said == std::vector{FleetKind::run, FleetKind::pause});
    CHECK(runner.state_text().starts_with("paused: no new state of any peer for 1"));
    CHECK(runner.drops()["safety.paused"] == 1);
    CHECK(runner.drops()["gate.lost.b"] == 0);
    b.pass(1s, 1);
    CHECK(said == std::vector{FleetKind::run, FleetKind::pause, FleetKind::run});
    CHECK(runner.state_text() == "running");
    // A pause of the operator stays one.
    b.bench.tell(static_cast<std::uint8_t>(FleetKind::pause));
    b.pass(12s, 2);
    b.pass(1s, 3);
    CHECK(said.back() == FleetKind::pause);
    CHECK(runner.state_text() == "running, with its robots paused by the operator");
    CHECK(runner.drops()["safety.paused"] == 2);
  }
}

TEST_CASE("robots go on without news where arenas wait, or the lab is told so") {
  NewsBench waits({}, true), never([](lab::RunConfig&run) { run.safety.pause_after = 0s; });
  for (NewsBench* b : {&waits, &never}) {
    b->pass(20s, 0);
    CHECK(b->bench.runner.drops()["safety.paused"] == 0);
    CHECK(b->bench.arena.robots().commands == std::vector{hal::FleetCommand::Kind::run});
  }
}
