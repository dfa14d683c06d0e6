// Either side goes away: the labs go on or end as they are configured, by name, and the original is not hurt.
#include <doctest/doctest.h>

#include <chrono>
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

}  // namespace

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
  CHECK(run.lab("argos").state_text().find("the original M-ARK client (ARGoS), which is gone") != std::string::npos);
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
  CHECK(run.lab("argos").reason().find("the original M-ARK server (ARGoS), which is gone: it closed its connection") !=
        std::string::npos);
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
    CHECK(run.stand_in().conflict().find("tells of 1 robot:") != std::string::npos);
  }
  CreOriginalGround original(3, 35, 35);
  ScriptedNetwork network{.options = {}, .original = &original};
  StandInRun run(mark::Role::server, "cre_ground", "sky", network, {"run.duration_s=60"});
  run_out(run);
  CHECK(run.lab("argos").reason().find("scenario.cre.resources_north = 10, and the original has 35") !=
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
