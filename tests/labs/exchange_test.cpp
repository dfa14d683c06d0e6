// Time-based, event-based and mixed exchange between whole labs: DHTF in one process.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/joint_run.hpp"
#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/stepped_labs.hpp"
#include "tests/support/processes/thorough.hpp"

using namespace arkmesh;
using tests::Outcome;
using tests::run_labs;

namespace {

const char* const event = "gate.exchange=event";
const char* const mixed = "gate.exchange=mixed";
const char* const owner_each_6_s = "gate.down_period_s=6";

// The lab's "exchange" in its result, when it is over.
nlohmann::json figures(app::JointRun& run, const char* lab) {
  return run.lab(lab).runner().exchange_figures();
}

std::uint64_t sent_bytes(const std::vector<std::string>& overrides) {
  std::uint64_t bytes = 0;
  const Outcome outcome = run_labs({.overrides = overrides}, [&](app::JointRun& run) {
    bytes = figures(run, "shark")["sent"]["bytes"].get<std::uint64_t>() +
            figures(run, "roark")["sent"]["bytes"].get<std::uint64_t>();
  });
  REQUIRE(outcome.finished);
  return bytes;
}

// Two free labs whose arenas keep the time of the run's steps. `at` a second the link has something done to it.
struct Free {
  explicit Free(std::vector<std::string> overrides) {
    tests::add_stepped_arena();
    overrides.insert(overrides.begin(), {"arena.use=stepped", "run.duration_s=60", "gate.on_peer_lost=go_on"});
    run.emplace(tests::dhtf_configs({.overrides = overrides}), folder.path());
  }
  void go(const std::function<void(app::JointRun&)>& each_step = {}) {
    while (tests::step(*run))
      if (each_step) each_step(*run);
    REQUIRE(run->finished());
    CHECK_FALSE(run->lab(0).runner().strict());
  }
  double age(const char* lab, const char* peer) {
    return figures(*run, lab)["applied"][peer]["age_periods_mean"].get<double>();
  }
  tests::TemporaryFolder folder;
  std::optional<app::JointRun> run;
};

}  // namespace

TEST_CASE("exchange: by events and mixed, strict labs do what they do in time, with fewer bytes") {
  // Proves that in strict mode the modes differ in what they cost and in nothing that robots or sites do.
  const Outcome reference = run_labs({});
  REQUIRE(reference.completed > 0);
  CHECK(run_labs({.overrides = {event}}).hash == reference.hash);
  CHECK(run_labs({.overrides = {mixed}}).hash == reference.hash);
  CHECK(sent_bytes({event}) < sent_bytes({}));
}

TEST_CASE("exchange: longer periods and other modes keep their hash whatever the network does") {
  // Proves strictness with a payload that is older than its state, and that such a run is another one than the default.
  const std::uint64_t reference = run_labs({}).hash;
  for (const std::vector<std::string>& overrides :
       {std::vector<std::string>{event}, {mixed}, {mixed, owner_each_6_s}, {owner_each_6_s, "gate.up_period_s=4"}}) {
    if (!arkmesh::tests::thorough() && overrides.front() != mixed) continue;
    CAPTURE(overrides.back());
    const Outcome quiet = run_labs({.overrides = overrides});
    std::uint64_t cut_at = 0;
    bool gateway_killed = false;
    const Outcome noisy = run_labs({.overrides = overrides}, [&](app::JointRun& run) {
      const std::uint32_t period = run.lab(0).runner().period();
      if (period == 5) run.network().impair("shark", "roark", {.jitter_steps = 30, .loss = 0.4, .repeat = 0.3});
      if (period == 20 && cut_at == 0) {
        cut_at = run.steps();
        run.network().set_up("shark", "roark", false);
      }
      if (cut_at > 0 && run.steps() == cut_at + 5000) run.network().set_up("shark", "roark", true);
      if (period == 30 && !gateway_killed) {
        gateway_killed = true;
        run.kill_gateway("roark"), run.start_gateway("roark");
      }
    });
    CHECK(cut_at > 0);
    CHECK(gateway_killed);
    REQUIRE(quiet.finished);
    REQUIRE(noisy.finished);
    CHECK(noisy.steps > quiet.steps);
    CHECK(noisy.hash == quiet.hash);
    CHECK((quiet.hash == reference) == (overrides.size() == 1));
  }
}

TEST_CASE("exchange: mixed, the owner's snapshots confirm the others' events") {
  nlohmann::json roark, shark;
  const Outcome outcome = run_labs({.overrides = {mixed, owner_each_6_s}}, [&](app::JointRun& run) {
    roark = figures(run, "roark"), shark = figures(run, "shark");
  });
  REQUIRE(outcome.finished);
  const auto told = roark["events"]["told"].get<std::uint64_t>(),
             confirmed = roark["events"]["confirmed"].get<std::uint64_t>();
  CHECK(told > 0);
  CHECK(confirmed <= told);
  CHECK(confirmed + 3 >= told);  // the last ones have no snapshot any more
  CHECK(roark["events"]["unconfirmed"] == 0);
  CHECK(shark["events"]["told"] == 0);
  CHECK(roark["applied"]["shark"]["age_periods_most"] == 2);
  CHECK(roark["applied"]["shark"]["age_periods_mean"] == 1.0);
}

TEST_CASE("exchange: free labs are told of events before the boundary, and apply them although states come late") {
  // Proves that early events make what a lab applies fresher where the network takes longer than nothing: each state
  // comes 300 ms after its boundary, and is applied at the next; most of what changed has come by then.
  const auto age = [](const char* mode, std::uint64_t* early = nullptr) {
    Free labs({std::string("gate.exchange=") + mode, "scenario.dhtf.types=easy"});
    labs.run->network().impair("shark", "roark", {.delay_steps = 300});
    labs.go();
    if (early) *early = labs.run->lab("roark").runner().drops()["gate.early.shark"];
    return labs.age("roark", "shark");
  };
  std::uint64_t early = 0;
  CHECK(age("time") == doctest::Approx(1.0).epsilon(0.05));
  CHECK(age("event", &early) < 0.8);
  CHECK(early > 5);
}

TEST_CASE("exchange: free labs resend events that a cut has kept from being confirmed") {
  Free labs({mixed, "scenario.dhtf.types=easy"});
  labs.go([](app::JointRun& run) {
    if (run.steps() == 20'000) run.network().set_up("shark", "roark", false);
    if (run.steps() == 40'000) run.network().set_up("shark", "roark", true);
  });
  const nlohmann::json events = figures(*labs.run, "roark")["events"];
  CHECK(events["unconfirmed"].get<std::uint64_t>() > 0);
  CHECK(labs.run->lab("roark").runner().drops()["exchange.unconfirmed"] == events["unconfirmed"]);
  CHECK(events["confirmed"].get<std::uint64_t>() + 3 >= events["told"].get<std::uint64_t>());
}
