// Time-based, event-based and mixed exchange: which payload a state carries, what goes on the wire, and that a strict
// gate merges the same whatever the network does.
#include "lab/exchange/exchange.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "lab/exchange/confirmations.hpp"
#include "lab/run_config.hpp"
#include "tests/lab/gate_model.hpp"
#include "tests/support/processes/thorough.hpp"

using namespace arkmesh;
using lab::Exchange;
using lab::LabState;
using lab::PeriodGate;
using lab::WorldMessage;
using tests::GateModel;

namespace {

using Mode = Exchange::Mode;

const Exchange by_time{}, by_event{.mode = Mode::event}, mixed{.mode = Mode::mixed};

Exchange every(Mode mode, std::uint32_t up, std::uint32_t down) {
  return {.mode = mode, .up_periods = up, .down_periods = down};
}

const std::vector<lab::FieldRule> rules = {{.name = "once", .length = 1, .high = 100, .initial_only = true},
                                           {.name = "team", .length = 1, .high = 100},
                                           {.name = "note", .length = 1, .high = 100, .bookkeeping = true}};

LabState team_state(std::uint32_t period, std::int64_t team, std::int64_t note = 0) {
  LabState s{.period = period, .hash = period + 100};
  s.robots = {{.robot = 1, .in_shared = {.x_m = 0.001 * period}}};
  s.fields = {{"team", {team}}, {"note", {note}}};
  if (period == 0) {
    s.fields["once"] = {7};
    s.settings["run.seed"] = "1";
  }
  return s;
}

// At which boundary the payload of each state was made.
std::vector<std::uint32_t> payloads_of(const Exchange& exchange, bool is_owner,
                                       const std::vector<std::int64_t>& teams) {
  lab::OwnPayload payload(exchange, is_owner);
  std::vector<std::uint32_t> made;
  for (std::size_t k = 0; k < teams.size(); ++k) {
    LabState own = team_state(static_cast<std::uint32_t>(k), teams[k], static_cast<std::int64_t>(k));
    payload.settle(own, rules);
    made.push_back(lab::payload_period(own));
    CHECK(own.robots.front().in_shared.x_m == 0.001 * made.back());
    CHECK(own.fields.at("team").front() == teams[made.back()]);
    CHECK(own.fields.contains("once") == (k == 0));
  }
  return made;
}

PeriodGate gate_by(const Exchange& exchange, bool can_wait = true) {
  PeriodGate a(
      {.lab = "a", .labs = {"a", "b"}, .last_period = 100, .run_id = 1, .can_wait = can_wait, .exchange = exchange});
  a.set_rules({"a",
               [] {
                 auto all = rules;
                 all.push_back(lab::arena_rule());
                 return all;
               }(),
               {{"a", {}}, {"b", {}}}});
  return a;
}

LabState of_b(std::uint32_t period, std::int64_t team) {
  LabState s = team_state(period, team);
  if (period == 0) s.fields[lab::arena_rule().name] = {1'000'000, 1'000'000, 5, 5};
  return s;
}

WorldMessage said_by_b(std::vector<LabState> window, bool can_wait = true) {
  WorldMessage m{.lab = "b", .run_id = 2, .can_wait = can_wait, .window = std::move(window)};
  m.acks["a"] = {1, -1};
  return m;
}

// State `period` that repeats what was made at `made`, left out.
LabState clock_part(std::uint32_t period, std::uint32_t made) {
  LabState s{.period = period, .hash = period + 100};
  s.made_at = made;
  s.carried = false;
  return s;
}

std::string why_refused(const WorldMessage& message, auto change) {
  world_t m = lab::to_message(message);
  change(m);
  std::vector<std::byte> bytes(static_cast<std::size_t>(m.getEncodedSize()));
  m.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  WorldMessage out;
  return std::string(lab::decode_world(bytes, out));
}

}  // namespace

TEST_CASE("exchange: random schedules give equal merge sequences in every mode") {
  // Proves that no mode makes what labs merge depend on what the network did, for 2 and 3 labs and slack 0 to 2; and
  // that a network that loses more is told more, never something else.
  const std::vector<Exchange> modes = {every(Mode::time, 3, 2), by_event, mixed, every(Mode::mixed, 1, 4)};
  std::map<std::tuple<std::size_t, int, std::uint32_t>, std::uint64_t> results;
  for (std::uint64_t schedule = 0; schedule < (arkmesh::tests::thorough() ? 4'000U : 168U); ++schedule) {
    const std::size_t mode = schedule % modes.size();
    GateModel model({.labs = 2 + static_cast<int>(schedule / 4 % 2),
                     .slack = static_cast<std::uint32_t>(schedule / 8 % 3),
                     .periods = 12,
                     .schedule_seed = schedule,
                     .loss = 0.1 * static_cast<double>(schedule % 7),
                     .exchange = modes[mode],
                     .seldom = true});
    REQUIRE(model.run());
    REQUIRE(model.gate(0).counters()["world.refused.payload"] == 0);
    const auto [it, first] = results.emplace(
        std::tuple{mode, 2 + static_cast<int>(schedule / 4 % 2), static_cast<std::uint32_t>(schedule / 8 % 3)},
        model.result());
    REQUIRE(it->second == model.result());
  }
  CHECK(results.size() == 24);
}

TEST_CASE("exchange: by events labs merge what they merge in time, and longer periods merge something else") {
  // Proves that events leave nothing out of what the fields tell, and that the test above can fail.
  const auto run = [](const Exchange& exchange) {
    GateModel model({.periods = 40, .exchange = exchange, .seldom = true});
    REQUIRE(model.run());
    return std::pair{model.result(), model.payloads()};
  };
  const auto reference = run(by_time), events = run(by_event), both = run(mixed);
  CHECK(events.first == reference.first);
  CHECK(both.first == reference.first);
  CHECK(events.second < reference.second);
  CHECK(run(every(Mode::time, 1, 2)).first != reference.first);
  CHECK(run(every(Mode::time, 2, 1)).first != reference.first);
  CHECK(run(every(Mode::mixed, 1, 2)).first != reference.first);
}

TEST_CASE("exchange: a state repeats its payload until it is time, or a field has changed") {
  // Robots' places are no events, nor is what the owner notes down; what belongs to state 0 is not repeated.
  using Made = std::vector<std::uint32_t>;
  const std::vector<std::int64_t> teams = {0, 0, 1, 1, 1, 0, 2};
  CHECK(payloads_of(by_time, true, teams) == Made{0, 1, 2, 3, 4, 5, 6});
  CHECK(payloads_of(every(Mode::time, 3, 2), true, teams) == Made{0, 0, 2, 2, 4, 4, 6});
  CHECK(payloads_of(every(Mode::time, 3, 2), false, teams) == Made{0, 0, 0, 3, 3, 3, 6});
  for (const bool is_owner : {true, false}) CHECK(payloads_of(by_event, is_owner, teams) == Made{0, 0, 2, 2, 2, 5, 6});
  CHECK(payloads_of(every(Mode::mixed, 1, 4), true, teams) == Made{0, 0, 0, 0, 4, 4, 4});
  CHECK(payloads_of(every(Mode::mixed, 1, 4), false, teams) == Made{0, 0, 2, 2, 2, 5, 6});
}

TEST_CASE("exchange: of a lab that publishes nothing that changes, a robot's LED is an event") {
  const auto made = [](std::vector<LabState> states) {
    lab::OwnPayload payload(by_event, false);
    std::vector<std::uint32_t> out;
    for (LabState& state : states) {
      state.fields.erase("team");
      payload.settle(state, rules);
      out.push_back(lab::payload_period(state));
    }
    return out;
  };
  std::vector<LabState> states;
  for (std::uint32_t k = 0; k < 4; ++k) states.push_back(team_state(k, 0, k));
  CHECK(made(states) == std::vector<std::uint32_t>{0, 0, 0, 0});
  states[2].robots.front().led = states[3].robots.front().led = hal::Led::red;
  CHECK(made(states) == std::vector<std::uint32_t>{0, 0, 2, 2});
  states[3].robots.push_back({.robot = 2});
  CHECK(made(states) == std::vector<std::uint32_t>{0, 0, 2, 3});
}

TEST_CASE("exchange: what a peer has is left out of messages, and what it lacks is not") {
  PeriodGate a = gate_by(by_event);
  lab::OwnPayload payload(by_event, true);
  const auto publish = [&](std::uint32_t period, std::int64_t team) {
    LabState own = team_state(period, team);
    payload.settle(own, rules);
    a.publish(own);
  };
  publish(0, 1);
  CHECK(a.message().window.front().carried);
  WorldMessage b = said_by_b({of_b(0, 0)});
  b.acks["a"].received = 0;
  REQUIRE(a.hear("b", b) == PeriodGate::Heard::counted);
  a.merge(0);
  CHECK_FALSE(a.message().window.front().carried);
  publish(1, 1);
  for (const LabState& state : a.message().window) CHECK_FALSE(state.carried);
  b = said_by_b({clock_part(1, 0)});
  REQUIRE(a.hear("b", b) == PeriodGate::Heard::counted);
  CHECK(a.merge(1)[1].payload_age_periods == 1);
  publish(2, 5);
  const WorldMessage m = a.message();
  CHECK_FALSE(m.window[0].carried);
  CHECK(m.window[1].carried);
  CHECK(a.newest("b")->fields.at("team").front() == 0);
  CHECK_FALSE(a.newest("b")->fields.contains("once"));
}

TEST_CASE("exchange: mixed, an event stays in messages until the owner's snapshot shows it") {
  PeriodGate a(
      {.lab = "a", .labs = {"a", "b"}, .last_period = 100, .run_id = 1, .exchange = mixed, .until_confirmed = true});
  a.publish(team_state(0, 1));
  WorldMessage b = said_by_b({of_b(0, 0)});
  b.acks["a"].received = 0;
  REQUIRE(a.hear("b", b) == PeriodGate::Heard::counted);
  CHECK(a.message().window.front().carried);
  a.confirm(0);
  CHECK_FALSE(a.message().window.front().carried);
}

TEST_CASE("exchange: a state that repeats what nobody was told is refused by name") {
  // Proves that a peer cannot make a lab take robots and fields for others than they are.
  PeriodGate a = gate_by(by_event);
  a.publish(team_state(0, 1));
  LabState nothing = clock_part(0, 0);
  nothing.settings["run.seed"] = "1";
  CHECK(a.hear("b", said_by_b({nothing})) == PeriodGate::Heard::refused);
  REQUIRE(a.hear("b", said_by_b({of_b(0, 3)})) == PeriodGate::Heard::counted);
  a.merge(0);
  a.publish(team_state(1, 1));
  const std::uint64_t before = a.counters()["world.refused.payload"];
  CHECK(a.hear("b", said_by_b({clock_part(1, 1)})) == PeriodGate::Heard::refused);
  CHECK(a.newest_refusal() ==
        "its state 1 refers to the robots and fields of its state 1, but this lab has those of its state 0");
  CHECK(a.counters()["world.refused.payload"] == before + 1);
  CHECK(a.received("b") == 0);
  CHECK(a.hear("b", said_by_b({clock_part(1, 0)})) == PeriodGate::Heard::counted);
  CHECK(a.merge(1)[1].state->fields.at("team").front() == 3);
}

TEST_CASE("exchange: a free lab applies an early event at its boundary when the state is late") {
  PeriodGate a = gate_by(by_event, false);
  a.publish(team_state(0, 1));
  REQUIRE(a.hear("b", said_by_b({of_b(0, 0)}, false)) == PeriodGate::Heard::counted);
  a.merge(0);
  WorldMessage early = said_by_b({of_b(0, 0)}, false);
  early.event = {.number = 2, .state = of_b(1, 4)};
  REQUIRE(a.hear("b", early) == PeriodGate::Heard::counted);
  early.event = {.number = 1, .state = of_b(1, 3)};  // overtaken
  REQUIRE(a.hear("b", early) == PeriodGate::Heard::counted);
  a.publish(team_state(1, 1));
  const lab::MergedState b = a.merge(1)[1];
  CHECK(b.state->fields.at("team").front() == 4);
  CHECK(b.state->period == 0);  // its clock is what it was
  CHECK(b.age_periods == 1);
  CHECK(b.payload_age_periods == 0);
  CHECK(a.counters()["gate.early.b"] == 1);
  // its state of the next boundary counts more
  REQUIRE(a.hear("b", said_by_b({of_b(1, 9)}, false)) == PeriodGate::Heard::counted);
  a.publish(team_state(2, 1));
  CHECK(a.merge(2)[1].state->fields.at("team").front() == 9);
  // an event of the future, of the past, or against the rules is none
  for (const std::uint32_t period : {1u, 3u, 101u}) {
    WorldMessage lie = said_by_b({of_b(1, 9)}, false);
    lie.event = {.number = 1, .state = of_b(period, 4)};
    CHECK(a.hear("b", lie) == PeriodGate::Heard::refused);
  }
  WorldMessage lie = said_by_b({of_b(1, 9)}, false);
  lie.event = {.number = 1, .state = of_b(2, 4)};
  lie.event->state.fields["team"] = {1, 2};
  CHECK(a.hear("b", lie) == PeriodGate::Heard::refused);
  CHECK(a.counters()["world.refused.field_length"] == 1);
}

TEST_CASE("exchange: a strict lab does not apply events") {
  PeriodGate a = gate_by(by_event);
  a.publish(team_state(0, 1));
  WorldMessage early = said_by_b({of_b(0, 2)});
  REQUIRE(a.hear("b", early) == PeriodGate::Heard::counted);
  a.merge(0);
  early.event = {.number = 1, .state = of_b(1, 4)};
  REQUIRE(a.hear("b", early) == PeriodGate::Heard::counted);
  CHECK(a.counters()["world.event_ignored"] == 1);
  a.publish(team_state(1, 1));
  CHECK_FALSE(a.may_merge(1));
  REQUIRE(a.hear("b", said_by_b({clock_part(1, 0)})) == PeriodGate::Heard::counted);
  CHECK(a.merge(1)[1].state->fields.at("team").front() == 2);
}

TEST_CASE("exchange: an own early event is part of messages until its boundary") {
  PeriodGate a = gate_by(by_event, false);
  a.publish(team_state(0, 1));
  a.publish_early(team_state(1, 2));
  a.publish_early(team_state(1, 3));
  REQUIRE(a.message().event);
  CHECK(a.message().event->number == 2);
  CHECK(a.message().event->state.fields.at("team").front() == 3);
  a.publish(team_state(1, 3));
  CHECK_FALSE(a.message().event);
}

TEST_CASE("exchange: marks and events survive the network, and false ones are refused by name") {
  WorldMessage m = said_by_b({of_b(1, 3), clock_part(2, 1)});
  m.window[0].made_at = 0;
  m.event = {.number = 3, .state = of_b(3, 4)};
  world_t out = lab::to_message(m);
  std::vector<std::byte> bytes(static_cast<std::size_t>(out.getEncodedSize()));
  out.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  WorldMessage back;
  REQUIRE(lab::decode_world(bytes, back) == "");
  REQUIRE(back.window.size() == 2);
  CHECK(back.window[0].made_at == 0u);
  CHECK(back.window[0].carried);
  CHECK(back.window[0].fields == m.window[0].fields);
  CHECK(back.window[1].made_at == 1u);
  CHECK_FALSE(back.window[1].carried);
  REQUIRE(back.event);
  CHECK(back.event->number == 3);
  CHECK(back.event->state.fields == m.event->state.fields);
  CHECK(back.event->state.robots.size() == 1);

  const auto mark = [](world_t& w, std::size_t state) -> std::vector<std::int64_t>& {
    for (field_t& field : w.window[state].fields)
      if (field.name.starts_with("lab.")) return field.values;
    throw std::logic_error("no mark");
  };
  CHECK(why_refused(m, [](world_t&) {}) == "");
  CHECK(why_refused(m, [&](world_t& w) { mark(w, 0)[0] = 2; }) == "payload");  // in the future
  CHECK(why_refused(m, [&](world_t& w) { mark(w, 0)[0] = -1; }) == "payload");
  CHECK(why_refused(m, [&](world_t& w) { mark(w, 0)[1] = 0; }) == "payload");  // left out, and yet there
  CHECK(why_refused(m, [&](world_t& w) { mark(w, 1)[1] = 2; }) == "payload");
  CHECK(why_refused(m, [&](world_t& w) { mark(w, 2)[0] = 0; }) == "event");
  CHECK(why_refused(m, [&](world_t& w) { std::swap(w.window[1], w.window[2]); }) == "event");
}

TEST_CASE("exchange: what of a lab's events has come through is counted") {
  lab::Confirmations events(3);
  events.published(1, true);
  events.published(2, true);
  events.shown(1);
  CHECK(events.confirmed() == 1);
  for (std::uint32_t k = 3; k < 5; ++k) events.published(k, false);
  CHECK(events.unconfirmed() == 0);
  for (std::uint32_t k = 5; k < 8; ++k) events.published(k, false);
  CHECK(events.unconfirmed() == 1);
  CHECK(events.resent() == 3);
  events.published(8, true);
  events.shown(8);
  events.published(9, false);
  CHECK(events.told() == 3);
  CHECK(events.confirmed() == 3);
  CHECK(events.unconfirmed() == 1);
  CHECK(events.resent() == 3);
}

TEST_CASE("exchange: its keys make sense together, or are refused with the remedy") {
  const auto read = [](const std::string& keys) {
    return hal::Config::from_text("[lab]\nname = \"a\"\n[run]\nscenario = \"x\"\n[gate]\n" + keys, "a.toml")
        .root()
        .read<lab::RunConfig>()
        .exchange;
  };
  const auto refused = [&](const std::string& keys) {
    try {
      read(keys);
    } catch (const hal::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(read("").plain());
  CHECK(read("period_s = 0.5").up == hal::LabTime(500'000));
  const Exchange apart = read("period_s = 0.5\nup_period_s = 1.5\ndown_period_s = 1");
  CHECK(apart.up_periods == 3);
  CHECK(apart.down_periods == 2);
  CHECK(read("exchange = \"mixed\"\ndown_period_s = 10").down_periods == 5);
  CHECK(refused("up_period_s = 3") ==
        "a.toml:6: gate.up_period_s = 3.0: must be a whole multiple of gate.period_s, which is 2");
  CHECK(refused("down_period_s = 1").find("whole multiple") != std::string::npos);
  CHECK(refused("exchange = \"event\"\ndown_period_s = 4").find("use \"mixed\"") != std::string::npos);
  CHECK(refused("exchange = \"mixed\"\nup_period_s = 4").find("by event; remove it") != std::string::npos);
  CHECK(refused("exchange = \"often\"").find("\"time\"") != std::string::npos);
}
