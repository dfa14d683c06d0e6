#include "lab/exchange/period_gate.hpp"

#include <doctest/doctest.h>

#include <map>
#include <vector>

#include "tests/lab/gate_model.hpp"
#include "tests/support/processes/thorough.hpp"

using namespace arkmesh;
using lab::LabState;
using lab::PeriodGate;
using lab::WorldMessage;
using tests::GateModel;
using tests::GateModelOptions;

namespace {

LabState state(std::uint32_t period, std::uint64_t hash = 7) {
  LabState s;
  s.period = period;
  s.hash = hash;
  if (period == 0) s.settings["run.seed"] = "1";
  return s;
}

PeriodGate gate(std::uint32_t slack = 0, bool can_wait = true) {
  return PeriodGate(
      {.lab = "a", .labs = {"a", "b"}, .slack = slack, .last_period = 100, .run_id = 1, .can_wait = can_wait});
}

// What b says to a, in answer to run id 1.
WorldMessage from_b(std::vector<LabState> window, std::int64_t received = -1) {
  WorldMessage m;
  m.lab = "b";
  m.run_id = 2;
  m.acks["a"] = {1, received};
  m.window = std::move(window);
  return m;
}

// What a real-time b says.
WorldMessage from_real_time_b(std::uint64_t run_id, std::vector<LabState> window) {
  WorldMessage m = from_b(std::move(window));
  m.run_id = run_id;
  m.can_wait = false;
  return m;
}

// Lab a after 19 periods beside a real-time b.
PeriodGate beside_real_time_b(bool can_wait) {
  PeriodGate a = gate(0, can_wait);
  a.publish(state(0));
  REQUIRE(a.hear("b", from_real_time_b(2, {state(0, 10)})) == PeriodGate::Heard::counted);
  for (std::uint32_t k = 0; k < 20; ++k) {
    if (k > 0) a.publish(state(k));
    a.merge(k);
  }
  return a;
}

}  // namespace

TEST_CASE("random schedules of loss, repetition and reordering give equal merge sequences") {
  // Proves that what the labs merge does not depend on what the network did, for 2 and 3 labs and slack 0 to 2.
  std::map<std::pair<int, std::uint32_t>, std::uint64_t> results;
  for (std::uint64_t schedule = 0; schedule < (arkmesh::tests::thorough() ? 10'000U : 240U); ++schedule) {
    GateModelOptions options{.labs = 2 + static_cast<int>(schedule % 2),
                             .slack = static_cast<std::uint32_t>(schedule / 2 % 3),
                             .periods = 12,
                             .schedule_seed = schedule,
                             .loss = 0.1 * static_cast<double>(schedule % 7)};
    GateModel model(options);
    REQUIRE(model.run());
    REQUIRE_FALSE(model.restarted_heard());
    const auto [it, first] = results.emplace(std::pair{options.labs, options.slack}, model.result());
    REQUIRE(it->second == model.result());
  }
  CHECK(results.size() == 6);
}

TEST_CASE("a window one state shorter deadlocks") {
  // Proves that 2*slack+2 states are needed, and that the test above can fail.
  int deadlocks = 0;
  for (std::uint64_t schedule = 0; schedule < 40; ++schedule) {
    const auto slack = static_cast<std::uint32_t>(schedule % 3);
    GateModel model(
        {.labs = 2, .slack = slack, .periods = 1000, .window = 2 * slack + 1, .schedule_seed = schedule, .loss = 0.5});
    deadlocks += model.run() ? 0 : 1;
  }
  CHECK(deadlocks == 40);
}

TEST_CASE("another seed, another slack and another behaviour give another merge sequence") {
  // Proves that equal results above are no accident of the measure.
  const auto result = [](GateModelOptions options) {
    GateModel model(options);
    REQUIRE(model.run());
    return model.result();
  };
  const std::uint64_t reference = result({});
  CHECK(reference != result({.world_seed = 2}));
  CHECK(reference != result({.slack = 1}));
  CHECK(reference != result({.moved_site = 1}));
  CHECK(reference == result({.schedule_seed = 99}));
}

TEST_CASE("a message that does not name our run id teaches its run id and nothing else") {
  // Proves that leftovers of an earlier run are harmless.
  PeriodGate a = gate();
  a.publish(state(0));
  WorldMessage old = from_b({state(0)});
  old.acks["a"].run_id = 77;
  CHECK(a.hear("b", old) == PeriodGate::Heard::taught);
  CHECK(a.received("b") == -1);
  CHECK(a.message().acks.at("b").run_id == 2);
  CHECK(a.hear("b", from_b({state(0)})) == PeriodGate::Heard::counted);
  CHECK(a.received("b") == 0);
}

TEST_CASE("a bound peer that answers with another run id was restarted") {
  // Proves rule 6's second half.
  PeriodGate a = gate();
  a.publish(state(0));
  REQUIRE(a.hear("b", from_b({state(0)})) == PeriodGate::Heard::counted);
  WorldMessage again = from_b({state(0)});
  again.run_id = 3;
  CHECK(a.hear("b", again) == PeriodGate::Heard::restarted);
}

TEST_CASE("state 0 may come together with later states") {
  // Proves that a peer whose first message was lost is believed: what is checked against its state 0 finds it in the
  // same message.
  PeriodGate a({.lab = "a", .labs = {"a", "b"}, .slack = 1, .last_period = 100, .run_id = 1});
  a.set_rules({"a", {lab::arena_rule()}, {{"a", {}}, {"b", {}}}});
  a.publish(state(0));
  LabState first = state(0), crowded = state(1), fits = state(1);
  first.fields[lab::arena_rule().name] = {1'000'000, 1'000'000, 1, 0};  // one robot
  fits.robots.resize(1);
  crowded.robots.resize(2);
  CHECK(a.hear("b", from_b({fits})) == PeriodGate::Heard::refused);
  CHECK(a.counters()["world.refused.before_initial"] == 1);
  CHECK(a.hear("b", from_b({first, crowded})) == PeriodGate::Heard::refused);
  CHECK(a.counters()["world.refused.robots"] == 1);
  CHECK(a.received("b") == -1);
  CHECK(a.hear("b", from_b({first, fits})) == PeriodGate::Heard::counted);
  CHECK(a.received("b") == 1);
}

TEST_CASE("lies are refused by name, counted, and change nothing") {
  // Proves that each false statement of a peer is found, before anything of its message counts.
  PeriodGate a = gate(1);
  a.publish(state(0));
  REQUIRE(a.hear("b", from_b({state(0), state(1)})) == PeriodGate::Heard::counted);
  struct Lie {
    const char* why;
    std::string origin = "b";
    WorldMessage message;
  };
  WorldMessage other_lab = from_b({state(0)}), flips = from_b({state(0)}), no_run_id = from_b({state(0)}),
               not_for_us = from_b({state(0)});
  other_lab.lab = "c";
  flips.can_wait = false;
  no_run_id.run_id = 0;
  not_for_us.acks.clear();
  const std::vector<Lie> lies = {
      {"other_name", "b", other_lab},
      {"unknown_lab", "c", other_lab},
      {"run_id", "b", no_run_id},
      {"not_for_us", "b", not_for_us},
      {"can_wait_changed", "b", flips},
      {"acknowledges_the_future", "b", from_b({state(2)}, 1)},
      {"period", "b", from_b({state(3)})},  // more than slack + 1 ahead of us
      {"period", "b", from_b({state(1'000'000'000)})},
      {"order", "b", from_b({state(2), state(1)})},
      {"order", "b", from_b({state(2), state(2)})},
      {"gap", "b", from_b({state(1), state(3)})},
      {"changed", "b", from_b({state(1, 8), state(2)})},
      {"settings", "b",
       from_b({state(1),
               [] {
                 LabState s = state(2);
                 s.settings["run.seed"] = "1";
                 return s;
               }()})},
  };
  for (const Lie& lie : lies) {
    CAPTURE(lie.why);
    const std::string counter = std::string("world.refused.") + lie.why;
    const std::uint64_t before = a.counters()[counter];
    CHECK(a.hear(lie.origin, lie.message) == PeriodGate::Heard::refused);
    CHECK(a.counters()[counter] == before + 1);
    CHECK(a.received("b") == 1);
    CHECK(a.newest("b")->hash == 7);
  }
}

TEST_CASE("a difference of settings is found with its key and both values") {
  // Proves that labs which do not mean the same world never start.
  PeriodGate a = gate();
  a.publish(state(0));
  WorldMessage other = from_b({state(0)});
  other.window[0].settings["run.seed"] = "2";
  CHECK(a.hear("b", other) == PeriodGate::Heard::different);
  CHECK(a.difference() == "run.seed is 1 in a and 2 in b");
  WorldMessage more = from_b({state(0)});
  more.window[0].settings["scenario.dhtf.sites"] = "8";
  CHECK(a.hear("b", more) == PeriodGate::Heard::different);
  CHECK(a.difference() == "scenario.dhtf.sites is not set in a and 8 in b");
  CHECK_FALSE(a.bound("b"));
}

TEST_CASE("a strict lab merges exactly k - slack and no lab is more than slack + 1 ahead") {
  // Proves rule 4 and the bound on the distance between labs.
  PeriodGate a = gate(1);
  a.publish(state(0));
  CHECK_FALSE(a.may_merge(0));
  REQUIRE(a.hear("b", from_b({state(0, 10)})) == PeriodGate::Heard::counted);
  CHECK(a.mode() == PeriodGate::Mode::strict);
  for (std::uint32_t k = 0; k < 2; ++k) {  // boundaries 0 and 1 both merge state 0
    if (k > 0) a.publish(state(k));
    REQUIRE(a.may_merge(k));
    const auto merged = a.merge(k);
    REQUIRE(merged.size() == 2);
    CHECK(merged[0].lab == "a");
    CHECK(merged[1].state->hash == 10);
  }
  a.publish(state(2));
  CHECK_FALSE(a.may_merge(2));  // needs b's state 1
  REQUIRE(a.hear("b", from_b({state(0, 10), state(1, 11), state(2, 12)})) == PeriodGate::Heard::counted);
  REQUIRE(a.may_merge(2));
  CHECK(a.merge(2)[1].state->hash == 11);
}

TEST_CASE("a free lab merges the newest at or before and counts what is late or skipped") {
  // Proves rule 11's choice and its counters.
  PeriodGate a = gate(0, false);
  a.publish(state(0));
  REQUIRE(a.hear("b", from_b({state(0, 10)})) == PeriodGate::Heard::counted);
  CHECK(a.mode() == PeriodGate::Mode::free);
  a.merge(0);
  a.publish(state(1));
  CHECK(a.merge(1)[1].state->hash == 10);
  CHECK(a.counters()["gate.late.b"] == 1);
  a.publish(state(2));
  REQUIRE(a.hear("b", from_b({state(3, 13), state(4, 14)})) == PeriodGate::Heard::counted);
  CHECK(a.merge(2)[1].state->hash == 10);  // 3 and 4 are of the future
  a.publish(state(3));
  CHECK(a.merge(3)[1].state->hash == 13);
  CHECK(a.counters()["gate.skipped.b"] == 2);
  CHECK(a.counters()["gate.late.b"] == 2);
}

TEST_CASE("a free lab that has finished hears a peer whose clock is ahead") {
  // It is how it learns that nobody needs it any more.
  PeriodGate a = gate(0, false);
  a.publish(state(0));
  REQUIRE(a.hear("b", from_b({state(0, 10)})) == PeriodGate::Heard::counted);
  a.merge(0);
  a.finish_at(0);
  CHECK(a.message().done);
  CHECK(a.hear("b", from_b({state(3, 13), state(4, 14)}, 0)) == PeriodGate::Heard::counted);
  CHECK(a.acknowledged() >= 0);
  CHECK(a.hear("b", from_b({state(100), state(101)}, 0)) == PeriodGate::Heard::refused);  // past the settings' end
}

TEST_CASE("a free lab takes a restarted peer's new run for the former one") {
  // Its state 0 is told anew, and states are as old as they are since the two runs have met.
  PeriodGate a = beside_real_time_b(false);
  WorldMessage other = from_real_time_b(3, {state(0, 30)});
  other.window[0].settings["run.seed"] = "2";
  CHECK(a.hear("b", from_real_time_b(3, {state(1, 31)})) == PeriodGate::Heard::refused);
  CHECK(a.hear("b", other) == PeriodGate::Heard::refused);
  CHECK(a.newest_refusal() == "it was restarted with other settings: run.seed is 1 in a and 2 in b");
  CHECK(a.run_id("b") == 2);
  CHECK(a.hear("b", from_real_time_b(3, {state(0, 30), state(1, 31)})) == PeriodGate::Heard::counted);
  CHECK(a.run_id("b") == 3);
  CHECK(a.message().window.front().period == 0);  // which the new run has yet to hear of
  CHECK(a.hear("b", from_real_time_b(2, {state(0, 10)})) == PeriodGate::Heard::refused);  // on its way until now
  CHECK(a.run_id("b") == 3);
  const std::uint64_t late = a.counters()["gate.late.b"];
  for (std::uint32_t k = 20; k < 23; ++k) {
    CAPTURE(k);
    a.publish(state(k));
    const lab::MergedState b = a.merge(k)[1];
    CHECK(b.state->hash == std::min<std::uint64_t>(k + 11, 32));
    CHECK(b.age_periods == (k == 22 ? 1 : 0));
    CHECK((b.initial ? b.initial->hash : 0) == (k == 20 ? 30 : 0));
    a.hear("b", from_real_time_b(3, {state(1, 31), state(2, 32)}));
  }
  CHECK(a.counters()["gate.late.b"] == late + 1);
  CHECK(a.counters()["world.restarted"] == 1);
}

TEST_CASE("a free lab refuses a restarted peer that has decided its world anew") {
  // Scenarios read once what is decided once: sites, and what kind each is. What a lab tells of its arena may change.
  PeriodGate a = gate(0, false);
  a.set_rules({"b", {{.name = "site", .length = 2, .high = 15, .initial_only = true}, lab::arena_rule()}, {{"b", {}}}});
  const auto world = [](std::vector<std::int64_t> sites, std::int64_t robots) {
    LabState initial = state(0);
    initial.fields = {{"site", std::move(sites)}, {"lab.arena", {1'000'000, 1'000'000, robots, 9}}};
    return initial;
  };
  a.publish(state(0));
  REQUIRE(a.hear("b", from_real_time_b(2, {world({1, 2}, 10)})) == PeriodGate::Heard::counted);
  a.merge(0);
  CHECK(a.hear("b", from_real_time_b(3, {world({1, 3}, 10)})) == PeriodGate::Heard::refused);
  CHECK(a.newest_refusal() ==
        "it was restarted with another world: value 1 of its site was 2 and is 3; start all labs again");
  CHECK(a.counters()["world.refused.world"] == 1);
  CHECK(a.run_id("b") == 2);
  CHECK(a.hear("b", from_real_time_b(4, {world({1, 2}, 8)})) == PeriodGate::Heard::counted);
  CHECK(a.run_id("b") == 4);
}

TEST_CASE("a peer that is restarted without end is refused at last") {
  // Proves that its former runs, which are remembered, do not fill the memory.
  PeriodGate a = beside_real_time_b(false);
  std::uint64_t restarts = 0;
  while (restarts < 10'000 &&
         a.hear("b", from_real_time_b(3 + restarts, {state(0, 30), state(1, 31)})) == PeriodGate::Heard::counted)
    ++restarts;
  CHECK(restarts == 100);
  CHECK(a.newest_refusal() == "it was restarted 100 times; start all labs again");
  CHECK(a.run_id("b") == 102);
}

TEST_CASE("a free lab that begins while a peer is in mid-run merges that peer's newest states") {
  PeriodGate a = gate(0, false);
  a.publish(state(0));
  a.hear("b", from_b({state(0, 10), state(50, 60)}));
  a.hear("b", from_b({state(0, 10), state(50, 60), state(51, 61)}));
  CHECK(a.merge(0)[1].state->hash == 10);
  a.publish(state(1));
  const lab::MergedState b = a.merge(1)[1];
  CHECK(b.state->hash == 61);
  CHECK(b.age_periods == 0);
}

TEST_CASE("a lab that can wait follows a restarted real-time arena from where that begins") {
  PeriodGate a = beside_real_time_b(true);
  a.hear("b", from_real_time_b(3, {state(0, 30), state(1, 31)}));
  CHECK(a.has_real_time_states(20));
  CHECK_FALSE(a.has_real_time_states(21));
}

TEST_CASE("a lab that can wait follows a real-time arena") {
  // Proves that a simulator beside a real-time arena merges no boundary before that arena's state k - slack is there.
  PeriodGate a = gate(0);
  a.publish(state(0));
  WorldMessage real_time = from_b({state(0)});
  real_time.can_wait = false;
  REQUIRE(a.hear("b", real_time) == PeriodGate::Heard::counted);
  CHECK(a.has_real_time_states(0));
  CHECK_FALSE(a.has_real_time_states(1));
  WorldMessage next = from_b({state(0), state(1)});
  next.can_wait = false;
  REQUIRE(a.hear("b", next) == PeriodGate::Heard::counted);
  CHECK(a.has_real_time_states(1));
}

TEST_CASE("state 0 stays in a free lab's message until every peer has it") {
  // Proves that a lab cut off while the others went on can still begin.
  PeriodGate a = gate(0, false);
  a.publish(state(0));
  REQUIRE(a.hear("b", from_b({state(0)})) == PeriodGate::Heard::counted);
  for (std::uint32_t k = 0; k < 6; ++k) {
    if (k > 0) a.publish(state(k));
    a.merge(k);
  }
  REQUIRE(a.message().window.size() == 3);
  CHECK(a.message().window.front().period == 0);
  REQUIRE(a.hear("b", from_b({state(0)}, 0)) == PeriodGate::Heard::counted);
  CHECK(a.message().window.size() == 2);
}
