#include <doctest/doctest.h>

#include <string>

#include "app/joint_run.hpp"
#include "tests/support/labs/dhtf_labs.hpp"

using namespace arkmesh;
using tests::Outcome;
using tests::run_labs;

namespace {

// Two labs of null arenas whose configurations differ by what is appended to roark's.
Outcome run_different(const std::string& roark_override) {
  const tests::TemporaryFolder folder;
  const std::vector<std::string> common = {"shared.labs=[\"roark\",\"shark\"]", "recorder.log=false",
                                           "run.duration_s=20", "arena.use=null"};
  std::vector<std::string> other = common;
  other.push_back(roark_override);
  std::vector<hal::Config> configs;
  configs.push_back(hal::Config::from_file(tests::experiments() / "dhtf" / "shark.toml", common));
  configs.push_back(hal::Config::from_file(tests::experiments() / "dhtf" / "roark.toml", other));
  app::JointRun run(std::move(configs), folder.path());
  while (run.step()) {
  }
  Outcome out;
  out.finished = run.finished();
  for (std::size_t i = 0; i < run.size(); ++i) out.reason += run.lab(i).runner().reason() + "\n";
  return out;
}

}  // namespace

TEST_CASE("labs with different settings never start, and both say which key differs") {
  // Proves rule 5: a difference in anything shared ends the labs with the key and both values named.
  struct Case {
    const char* change;
    const char* expected;
  };
  for (const Case& c :
       {Case{"run.seed=2", "run.seed is 1 in shark and 2 in roark"},
        Case{"gate.slack=1", "gate.slack is 0 in shark and 1 in roark"},
        Case{"run.duration_s=40", "run.duration_s is 20"},
        Case{"shared.projection.roark.scale=3.0", "shared.projection.roark.scale is 2.0 in shark and 3.0 in roark"},
        Case{"scenario.dhtf.respawn_s=50", "scenario.dhtf.respawn_s is"},
        Case{"gate.exchange=event", "gate.exchange is \"time\" in shark and \"event\" in roark"},
        Case{"gate.up_period_s=4", "gate.up_period_s is gate.period_s in shark and 4.0 in roark"},
        Case{"gate.down_period_s=4", "gate.down_period_s is gate.period_s in shark and 4.0 in roark"},
        Case{"gate.period_s=1.0", "gate.period_s is 2.0 in shark and 1.0 in roark"}}) {
    CAPTURE(std::string(c.change));
    const Outcome outcome = run_different(c.change);
    CAPTURE(outcome.reason);
    CHECK_FALSE(outcome.finished);
    CHECK(outcome.reason.find(c.expected) != std::string::npos);
    // Both labs say so, each naming itself first.
    CHECK(outcome.reason.find(" in roark") != std::string::npos);
    CHECK(outcome.reason.find("in shark\n") != std::string::npos);
  }
}

TEST_CASE("a strict gate refuses a real-time arena by name") {
  // Proves rule 10's refusal.
  const Outcome outcome =
      run_labs({.overrides = {"arena.use=null", "arena.pace=1.0", "gate.mode=strict", "run.duration_s=2"}});
  CHECK_FALSE(outcome.finished);
  CHECK(outcome.reason.find("gate.mode") != std::string::npos);
}

TEST_CASE("null labs finish and agree") {
  // Proves that the runner needs nothing from the simulator.
  const Outcome outcome = run_labs({.overrides = {"arena.use=null"}});
  CHECK(outcome.finished);
  CHECK(outcome.completed == 0);
}

TEST_CASE("a free run of real-time arenas ends by itself") {
  // Proves that labs that cannot wait run to their end in free mode, in real time.
  const Outcome outcome =
      run_labs({.overrides = {"arena.use=null", "arena.pace=1.0", "run.duration_s=2", "gate.period_s=0.5"}});
  CHECK(outcome.finished);
}
