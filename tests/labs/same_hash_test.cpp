#include <doctest/doctest.h>

#include <string>

#include "tests/support/labs/dhtf_labs.hpp"

using namespace arkmesh;
using tests::Outcome;
using tests::run_labs;

namespace {

const Outcome& reference() {
  static const Outcome outcome = run_labs({});
  return outcome;
}

// Boundaries that lab 0 has passed.
std::uint32_t period(app::JointRun& run) {
  return run.lab(0).runner().period();
}

}  // namespace

TEST_CASE("two runs with the same seed have the same hash, and tasks were completed") {
  // Proves that the rest of this file compares runs in which something happened.
  REQUIRE(reference().finished);
  CHECK(reference().completed > 0);
  CHECK(run_labs({}).hash == reference().hash);
}

TEST_CASE("a late, jittering, lossy and repeating network changes nothing") {
  // Proves that the hash is independent of what the links do to single messages.
  for (const gateway::LoopbackImpairment impairment :
       {gateway::LoopbackImpairment{.delay_steps = 20},
        {.delay_steps = 3, .jitter_steps = 40},
        {.loss = 0.5},
        {.repeat = 0.5},
        {.delay_steps = 5, .jitter_steps = 10, .loss = 0.3, .repeat = 0.3}}) {
    std::uint64_t impaired_at = 0;
    const Outcome outcome = run_labs({}, [&](app::JointRun& run) {
      if (impaired_at || period(run) < 10) return;
      run.network().impair("shark", "roark", impairment);
      impaired_at = run.steps();
    });
    REQUIRE(outcome.finished);
    CHECK(impaired_at > 0);
    // What holds messages up costs time, in mid-run; a repetition costs nothing.
    CHECK((outcome.steps > reference().steps || impairment.repeat > 0));
    CHECK(outcome.hash == reference().hash);
  }
}

TEST_CASE("a cut of thirty seconds in mid-run changes nothing") {
  // Proves that labs wait for a cut link and go on where they were.
  std::uint64_t cut_at = 0, healed_at = 0;
  std::uint32_t period_when_cut = 0, period_when_healed = 0;
  const Outcome outcome = run_labs({}, [&](app::JointRun& run) {
    if (!cut_at && period(run) == 20) {
      cut_at = run.steps();
      period_when_cut = period(run);
      run.network().set_up("shark", "roark", false);
    } else if (cut_at && !healed_at && run.steps() == cut_at + 30'000) {
      healed_at = run.steps();
      period_when_healed = period(run);
      run.network().set_up("shark", "roark", true);
    }
  });
  CAPTURE(outcome.reason);
  REQUIRE(outcome.finished);
  REQUIRE(healed_at > cut_at);
  CHECK(period_when_cut == 20);
  CHECK(period_when_healed <= 21);  // strict labs stop at most slack + 1 periods later
  CHECK(outcome.hash == reference().hash);
}

TEST_CASE("a gateway that dies and comes back changes nothing") {
  // Proves that nothing a gateway knows is needed for the result.
  std::uint64_t killed_at = 0, back_at = 0;
  const Outcome outcome = run_labs({}, [&](app::JointRun& run) {
    if (!killed_at && period(run) == 25) {
      killed_at = run.steps();
      run.kill_gateway("roark");
    } else if (killed_at && !back_at && run.steps() == killed_at + 8'000) {
      CHECK(period(run) <= 26);
      back_at = run.steps();
      run.start_gateway("roark");
    }
  });
  REQUIRE(outcome.finished);
  REQUIRE(back_at > killed_at);
  CHECK(outcome.hash == reference().hash);
}

TEST_CASE("another seed, another slack and a site moved by one millimetre give another hash") {
  // Proves that equal hashes above mean equal behaviour: each control changes only what robots do.
  for (const char* change : {"run.seed=2", "gate.slack=1", "scenario.dhtf.nudge_site_m=0.001"}) {
    CAPTURE(change);
    const Outcome outcome = run_labs({.overrides = {change}});
    REQUIRE(outcome.finished);
    CHECK(outcome.hash != reference().hash);
  }
}

TEST_CASE("slack keeps the hash independent of the network too") {
  // Proves the gate's rule for slack above zero with real labs.
  const tests::DhtfLabs slack{.overrides = {"gate.slack=2", "run.duration_s=60"}};
  const Outcome quiet = run_labs(slack);
  const Outcome noisy = run_labs(slack, [](app::JointRun& run) {
    if (period(run) == 5)
      run.network().impair("shark", "roark", {.delay_steps = 4, .jitter_steps = 30, .loss = 0.4, .repeat = 0.2});
  });
  REQUIRE(quiet.finished);
  REQUIRE(noisy.finished);
  CHECK(quiet.hash == noisy.hash);
}

TEST_CASE("three labs play one game, whatever their links do") {
  // Proves that a third lab joins by configuration, with a link for every pair.
  const tests::DhtfLabs three{.labs = {"shark", "roark", "lynx"}, .overrides = {"scenario.dhtf.types=easy"}};
  const Outcome quiet = run_labs(three);
  const Outcome noisy = run_labs(three, [](app::JointRun& run) {
    if (period(run) == 10) run.network().impair("roark", "lynx", {.delay_steps = 10, .loss = 0.5});
    if (period(run) == 20) run.network().impair("shark", "lynx", {.jitter_steps = 30});
  });
  REQUIRE(quiet.finished);
  CHECK(quiet.completed > 0);
  CHECK(quiet.hash == noisy.hash);
  CHECK(quiet.hash != reference().hash);
}

TEST_CASE("with the LEDs blanked no task is ever completed") {
  // Proves that the scenario knows a Kilobot by pose and LED only.
  const Outcome outcome = run_labs({.overrides = {"arena.blank_leds=true", "scenario.dhtf.types=easy"}});
  REQUIRE(outcome.finished);
  CHECK(outcome.completed == 0);
}
