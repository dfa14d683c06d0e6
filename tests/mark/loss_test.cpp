// Either side goes away: the labs go on or end as they are configured, by name, and the original is not hurt.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/mark/stand_in_run.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

namespace {

// Steps until the stand-in's lab has passed `period`; false when all has ended before.
bool reach(StandInRun& run, std::uint32_t period) {
  while (run.lab("argos").period() < period)
    if (!run.step()) return false;
  return true;
}

void run_out(StandInRun& run) {
  while (run.step()) {
  }
}

// Wall time that a test moves.
class MovedWall final : public hal::WallTime {
 public:
  hal::TimePoint now() override { return now_; }
  void wait_until(hal::TimePoint then) override { now_ = std::max(now_, then); }
  void pass(std::chrono::milliseconds time) { now_ += time; }

 private:
  hal::TimePoint now_{1h};
};

// Both sides have the same tasks when the labs have ended. An original server may have done one more in the last
// period.
void check_counts(StandInRun& run, const ScriptedOriginal& original, std::size_t done_before = 0) {
  run_out(run);
  CHECK(run.labs().finished());
  hal::Arena& arena = run.labs().lab("argos").arena();
  arena.end();
  for (int i = 0; i < 400; ++i) arena.serve();  // what is on its way arrives
  const std::uint64_t done = done_before + original.done.size();
  const auto late =
      std::ranges::count_if(original.done, [&](const auto& one) { return one.tick + 60 > original.ticks; });
  const std::uint64_t known = run.lab("argos").lab().counts()["completed"];
  CHECK(known == run.lab("shark").lab().counts()["completed"]);
  std::ifstream table(run.folder("shark") / "completed.csv");
  CHECK(std::count(std::istreambuf_iterator<char>(table), {}, '\n') == static_cast<std::ptrdiff_t>(1 + known));
  CHECK(known <= done);
  CHECK(known + static_cast<std::uint64_t>(late) >= done);
  CHECK(done > 5);
}

const std::string init = "Ibcghijko0000000000000000";  // easy tasks only, so that there are many

}  // namespace

TEST_CASE("labs and an original that is not waited for know of the same tasks, at any pace") {
  // Shark is cut off for 25 s of the original's; then the stand-in itself is not served for 100 s. Neither side acts
  // for moments that have passed.
  for (const bool is_server : {false, true})
    for (const unsigned serves_per_tick : {20u, 5u}) {
      CAPTURE(is_server);
      CAPTURE(serves_per_tick);
      DhtfOriginalClient client(1);
      DhtfOriginalServer server(2, init);
      ScriptedOriginal& original = is_server ? static_cast<ScriptedOriginal&>(server) : client;
      ScriptedNetwork network{.options = {.serves_per_tick = serves_per_tick}, .original = &original};
      StandInRun run(
          is_server ? mark::Role::client : mark::Role::server, "dhtf", "shark", network,
          {"run.duration_s=200", is_server ? "shared.owner=argos" : "shared.owner=shark", "scenario.dhtf.types=easy"});
      const auto pass = [&](std::uint64_t ticks) {
        for (const std::uint64_t until = original.ticks + ticks; original.ticks < until;) run.step();
      };
      REQUIRE(reach(run, 20));
      run.labs().kill_gateway("shark");
      pass(250);
      CHECK(run.lab("argos").period() <= 22);
      run.labs().start_gateway("shark");
      REQUIRE(reach(run, 50));
      network.stands = true;
      pass(1000);
      network.stands = false;
      check_counts(run, original);
      CHECK(original.most_unread <= 30);
      CHECK(run.lab("argos").drops()["arena.mark.skipped.ms"] > 110'000);
      CHECK(run.lab("argos").drops()["arena.mark.skipped.ms"] < 130'000);
    }
}

TEST_CASE("an original that is started again, three times, goes on with the same tasks") {
  for (const bool is_server : {false, true}) {
    CAPTURE(is_server);
    std::vector<std::unique_ptr<DhtfOriginal>> originals;
    for (unsigned i = 0; i < 4; ++i)
      if (is_server)
        originals.push_back(std::make_unique<DhtfOriginalServer>(2, init));
      else
        originals.push_back(std::make_unique<DhtfOriginalClient>(1 + i));
    ScriptedNetwork network{.options = {}, .original = originals[0].get()};
    StandInRun run(
        is_server ? mark::Role::client : mark::Role::server, "dhtf", "shark", network,
        {"run.duration_s=200", is_server ? "shared.owner=argos" : "shared.owner=shark", "scenario.dhtf.types=easy"});
    std::size_t before = 0;
    // In the handshake, at once; later; and after a while without.
    for (std::size_t i = 1; i < 4; ++i) {
      if (i == 1)
        for (const auto& first = *originals[0]; first.ticks < 3;) run.step();
      else
        REQUIRE(reach(run, 15 * static_cast<std::uint32_t>(i)));
      before += originals[i - 1]->done.size();
      network.original = i == 3 ? nullptr : originals[i].get();
      network.was_replaced = i < 3;
      for (int steps = 0; i == 3 && steps < 4000; ++steps) run.step();
      network.original = originals[i].get();
    }
    check_counts(run, *originals[3], before);
    CHECK(run.lab("argos").drops()["arena.mark.connections"] == 4);
  }
}

TEST_CASE("an ark-qt original is told what it can read, restarts by name, and does not act for moments that passed") {
  // 5 ms of the wall with each step, 20 of which are a service tick of it. It is stopped for 8 s, which must not kill
  // it.
  for (const bool is_server : {false, true}) {
    CAPTURE(is_server);
    MovedWall wall;
    ArkQtOriginalClient client(1);
    ArkQtOriginalServer server(2, init), other(2, "Ibcghijkn0000000000000000");
    ArkQtOriginal& original = is_server ? static_cast<ArkQtOriginal&>(server) : client;
    ScriptedNetwork network{.options = {}, .original = &original};
    StandInRun run(
        is_server ? mark::Role::client : mark::Role::server, "dhtf", "shark", network,
        {"run.duration_s=120", is_server ? "shared.owner=argos" : "shared.owner=shark", "scenario.dhtf.types=easy",
         "scenario.dhtf.requirements.argos=[2,6]", "mark.flavour=ark_qt", "mark.side_m=1.0"},
        wall);
    const auto step = [&] { return wall.pass(5ms), run.step(); };
    const auto go_to = [&](std::uint32_t period) {
      while (run.lab("argos").period() < period && step()) {
      }
      return run.lab("argos").period() >= period;
    };
    REQUIRE(go_to(10));
    network.options.serves_per_tick = 1u << 30;  // stopped
    for (int i = 0; i < 1600; ++i) step();
    network.options.serves_per_tick = 20;
    REQUIRE(go_to(20));
    CHECK_FALSE(original.died);
    run.labs().kill_gateway("shark");
    for (int i = 0; i < 4000; ++i) step();
    CHECK(run.lab("argos").period() <= 22);
    run.labs().start_gateway("shark");
    if (!is_server) {
      while (step()) {
      }
      check_counts(run, original);
    } else {
      REQUIRE(go_to(30));
      network.original = &other;
      network.was_replaced = true;
      int steps = 0;
      for (; step(); ++steps) {
      }
      CHECK(steps < 10'000);  // nobody waits for gate.patience_s
      for (const char* lab : {"argos", "shark"}) {
        const std::string& reason = run.lab(lab).reason();
        CHECK(
            reason.ends_with("start all labs again: the original server returned with another Init: "
                             "'Ibcghijko0000000000000000' before, 'Ibcghijkn0000000000000000' now"));
      }
    }
    CHECK_FALSE(original.died);
    CHECK_FALSE(other.died);
  }
}

TEST_CASE("an ark-qt server that is run again on its connection is asked for its sites") {
  // Soon, it is silent for less than what counts as gone.
  for (const auto& row : {std::pair{true, 10u}, {false, 10u}, {false, 1u}}) {
    const bool same = row.first;
    const unsigned period = row.second;
    CAPTURE(same);
    CAPTURE(period);
    MovedWall wall;
    ArkQtOriginalServer original(2, init);
    ScriptedNetwork network{.options = {}, .original = &original};
    StandInRun run(mark::Role::client, "dhtf", "shark", network,
                   {"run.duration_s=120", "shared.owner=argos", "scenario.dhtf.types=easy",
                    "scenario.dhtf.requirements.argos=[2,6]", "mark.flavour=ark_qt"},
                   wall);
    const auto step = [&] { return wall.pass(5ms), run.step(); };
    while (run.lab("argos").period() < period) REQUIRE(step());
    const std::string other = "Ibcghijkn0000000000000000";
    original.run_again(same ? init : other);
    while (step()) {
    }
    CHECK_FALSE(original.died);
    if (same) {
      check_counts(run, original);
    } else {
      for (const char* lab : {"argos", "shark"})
        CHECK(
            run.lab(lab).reason().ends_with("start all labs again: the original server returned with another Init: '" +
                                            init + "' before, '" + other + "' now"));
    }
  }
}

TEST_CASE("an ark-qt client that connects again keeps its sites, and does not acknowledge them again") {
  MovedWall wall;
  ArkQtOriginalClient original(1);
  ScriptedNetwork network{.options = {}, .original = &original};
  const auto begin = [&] {
    return std::make_unique<StandInRun>(
        mark::Role::server, "dhtf", "shark", network,
        std::vector<std::string>{"run.duration_s=200", "scenario.dhtf.types=easy",
                                 "scenario.dhtf.requirements.argos=[2,6]", "mark.flavour=ark_qt", "mark.side_m=1.0"},
        wall);
  };
  auto run = begin();
  const auto step = [&] { return wall.pass(5ms), run->step(); };
  while (run->lab("argos").period() < 20) REQUIRE(step());
  const std::size_t before = original.done.size();
  network.was_replaced = true;  // by itself
  while (step()) {
  }
  check_counts(*run, original);
  CHECK(original.done.size() > before + 5);
  // Labs that are started again may have other sites.
  run = begin();
  while (step()) {
  }
  CHECK(run->lab("argos").reason().ends_with(
      "the original client uses the sites of another server; restart it and this lab"));
}

TEST_CASE("an original client that is started again goes on where it was") {
  // It is gone at 20 s: lab time stands still, and its sites are ready for nobody. Another one comes, asks for Init,
  // gets it again, and the run ends as ever.
  DhtfOriginalClient first(1), second(5);
  ScriptedNetwork network{.options = {}, .original = &first};
  StandInRun run(mark::Role::server, "dhtf", "shark", network, {"run.duration_s=120"});
  REQUIRE(reach(run, 10));
  network.original = nullptr;
  for (int i = 0; i < 2000; ++i) run.step();
  CHECK(run.lab("argos").period() <= 11);
  CHECK(run.lab("argos").state_text().find("the original M-ARK client (ARGoS), which is disconnected") !=
        std::string::npos);
  network.original = &second;
  run_out(run);
  CHECK(run.labs().finished());
  CHECK(second.sites == first.sites);
  CHECK(second.types == first.types);
  CHECK(run.lab("argos").drops()["arena.mark.lost"] == 1);
  CHECK(run.lab("argos").drops()["arena.mark.connections"] == 2);
}

TEST_CASE("robots of the other labs pause while the original is away") {
  // Shark keeps the time of the run's steps. Ten seconds without anything new, by safety.pause_after_s, are 10,000
  // steps; its robots go on when the original is back.
  add_stepped_arena();
  DhtfOriginalClient first(1), second(5);
  ScriptedNetwork network{.options = {.serves_per_tick = 100}, .original = &first};
  StandInRun run(mark::Role::server, "dhtf", "shark", network,
                 {"run.duration_s=60", "safety.pause_after_s=10", "arena.use=stepped"});
  REQUIRE(reach(run, 5));
  network.original = nullptr;
  const auto is_paused = [&] { return run.lab("shark").state_text().find("paused") != std::string::npos; };
  for (int i = 0; i < 15'000 && !is_paused(); ++i) run.step();
  CHECK(is_paused());
  CHECK(run.lab("shark").drops()["safety.paused"] == 1);
  network.original = &second;
  for (int i = 0; i < 5000 && is_paused(); ++i) run.step();
  CHECK_FALSE(is_paused());
  CHECK_FALSE(second.sites.empty());
}

TEST_CASE("a lab that is told to end does so by name when the original goes") {
  DhtfOriginalServer original(2, "Ibcghijko0100101101011100");
  ScriptedNetwork network{.options = {}, .original = &original};
  StandInRun run(mark::Role::client, "dhtf", "shark", network,
                 {"run.duration_s=120", "shared.owner=argos", "gate.on_peer_lost=end"});
  REQUIRE(reach(run, 10));
  network.original = nullptr;
  run_out(run);
  CHECK_FALSE(run.lab("argos").finished());
  CHECK(run.lab("argos").reason().find(
            "the original M-ARK server (ARGoS), which is disconnected: it closed its connection") != std::string::npos);
  CHECK(run.lab("shark").reason().find("argos") != std::string::npos);
}

TEST_CASE("a lab that is told to go on does so by the wall's clock, and nobody of the original is ready") {
  // 20 s with the original, and 100 s without.
  MovedWall wall;
  DhtfOriginalClient original(1);
  ScriptedNetwork network{.options = {}, .original = &original};
  StandInRun run(mark::Role::server, "dhtf", "shark", network, {"run.duration_s=120", "gate.on_peer_lost=go_on"}, wall);
  REQUIRE(reach(run, 10));
  network.original = nullptr;
  run.step();
  const auto done = run.lab("shark").lab().counts()["completed"];
  while (run.step()) wall.pass(10ms);
  CHECK(run.labs().finished());
  CHECK(run.lab("shark").lab().counts()["completed"] <= done + 8);  // what had been ready already
  CHECK(run.lab("shark").lab().field("argos", "team") == std::vector<std::int64_t>(8, 0));
}

TEST_CASE("patience with an original ends") {
  MovedWall wall;
  DhtfOriginalClient original(1);
  ScriptedNetwork network{.options = {}, .original = &original};
  StandInRun run(mark::Role::server, "dhtf", "shark", network, {"run.duration_s=120", "gate.patience_s=30"}, wall);
  REQUIRE(reach(run, 10));
  network.original = nullptr;
  for (int i = 0; i < 20'000 && run.step(); ++i) wall.pass(10ms);
  CHECK(run.lab("argos").reason().find("gave up waiting after 30 s (gate.patience_s)") != std::string::npos);
}

TEST_CASE("an original server that comes back with other sites ends the run, and with the same ones goes on") {
  for (const bool same : {true, false}) {
    CAPTURE(same);
    DhtfOriginalServer first(2, "Ibcghijko0100101101011100"),
        second(3, same ? "Ibcghijko0100101101011100" : "Ibcghijkn0100101101011100");
    ScriptedNetwork network{.options = {}, .original = &first};
    StandInRun run(mark::Role::client, "dhtf", "shark", network, {"run.duration_s=120", "shared.owner=argos"});
    REQUIRE(reach(run, 10));
    network.original = &second;
    network.was_replaced = true;
    run_out(run);
    CHECK(run.labs().finished() == same);
    if (same) continue;
    const std::string& reason = run.lab("argos").reason();
    CHECK(reason.find("Ibcghijko0100101101011100") != std::string::npos);
    CHECK(reason.find("Ibcghijkn0100101101011100") != std::string::npos);
  }
}

TEST_CASE("an original server with another number of sites is a conflict that names both") {
  DhtfOriginalServer original(2, "Ibcghij010010110101");
  ScriptedNetwork network{.options = {}, .original = &original};
  StandInRun run(mark::Role::client, "dhtf", "shark", network, {"run.duration_s=60", "shared.owner=argos"});
  run_out(run);
  CHECK(run.stand_in().conflict().find("scenario.dhtf.sites = 8") != std::string::npos);
  CHECK(run.stand_in().conflict().find("has 6 sites ('Ibcghij010010110101')") != std::string::npos);
  CHECK(run.lab("argos").reason().find(run.stand_in().conflict()) != std::string::npos);
}

TEST_CASE("an original with other numbers of robots or resources is a conflict that names both") {
  {
    CreOriginalFlying original(4, 1);  // as the shipped file says
    ScriptedNetwork network{.options = {}, .original = &original};
    StandInRun run(mark::Role::client, "cre_flying", "meadow", network, {"run.duration_s=60"});
    run_out(run);
    CHECK(run.stand_in().conflict().find("mark.robots = 20") != std::string::npos);
    CHECK(run.stand_in().conflict().find("reports 1 robot;") != std::string::npos);
  }
  CreOriginalGround original(3, 35, 35);
  ScriptedNetwork network{.options = {}, .original = &original};
  StandInRun run(mark::Role::server, "cre_ground", "sky", network, {"run.duration_s=60"});
  run_out(run);
  CHECK(run.lab("argos").reason().find("scenario.cre.resources_north = 10, but the original has 35") !=
        std::string::npos);
}

TEST_CASE("a lab of another size than the original's is a conflict that names both") {
  // Shark's arena is 2 m wide at scale 1: its sites are not where the original has them.
  DhtfOriginalClient original(1);
  ScriptedNetwork network{.options = {}, .original = &original};
  StandInRun run(mark::Role::server, "dhtf", "shark", network,
                 {"run.duration_s=60", "shared.projection.shark.scale=2.0"});
  run_out(run);
  const std::string& reason = run.lab("argos").reason();
  CHECK(reason.find("whose arena is 1 m wide at scale 2") != std::string::npos);
  CHECK(reason.find("(mark.side_m) is 1 m wide at scale 1") != std::string::npos);
  CHECK(original.sites.empty());  // it was not told a wrong world
}

TEST_CASE("without the other labs nobody is ready for an original server") {
  // Shark's gateway is killed at 20 s. The original goes on by itself, and does no task with a team that may be gone.
  DhtfOriginalServer original(2, "Ibcghijko0000000000000000");
  ScriptedNetwork network{.options = {}, .original = &original};
  StandInRun run(mark::Role::client, "dhtf", "shark", network,
                 {"run.duration_s=300", "shared.owner=argos", "gate.on_peer_lost=go_on", "safety.pause_after_s=0"});
  REQUIRE(reach(run, 20));
  run.labs().kill_gateway("shark");
  REQUIRE(reach(run, 24));
  const std::size_t done = original.done.size();
  CHECK(done > 0);
  REQUIRE(reach(run, 140));
  CHECK(original.done.size() == done);
}

TEST_CASE("when the lab has ended the connection stays, and nobody is ready any more") {
  DhtfOriginalServer original(2, "Ibcghijko0000000000000000");
  ScriptedNetwork network{.options = {}, .original = &original};
  StandInRun run(mark::Role::client, "dhtf", "shark", network, {"run.duration_s=60", "shared.owner=argos"});
  run_out(run);
  CHECK(run.labs().finished());
  CHECK(run.stand_in().is_connected());
  hal::Arena& arena = run.labs().lab("argos").arena();
  arena.end();
  for (int i = 0; i < 40; ++i) arena.serve();
  const std::size_t done = original.done.size();
  for (int i = 0; i < 8000; ++i) arena.serve();  // 200 s of its time
  CHECK(original.done.size() == done);
  CHECK(run.stand_in().is_connected());
  CHECK(original.most_unread <= 30);
}
