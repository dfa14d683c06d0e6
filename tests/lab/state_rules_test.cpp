// Every lie about a state that the rules know, by its name.
#include "lab/exchange/state_rules.hpp"

#include <doctest/doctest.h>

#include <functional>

using namespace arkmesh;
using lab::LabState;

namespace {

// Labs a (the owner) and b; b's arena is 1 m by 0.5 m with two robots, ids to 9, seen at scale 2.
const lab::StateRules rules("a",
                            {lab::arena_rule(),
                             {.name = "team", .length = 2, .low = 0, .high = 5},
                             {.name = "site", .length = 1, .low = 0, .high = 9, .owner_only = true},
                             {.name = "once", .length = 1, .low = 0, .high = 9, .initial_only = true}},
                            {{"a", {}}, {"b", {.scale = 2}}});

std::string_view why_refused(std::string_view lab, const LabState& state, const LabState& initial) {
  const auto refused = rules.refusal(lab, state, initial);
  return refused ? refused->why : "";
}

LabState state_of_b(std::uint32_t period) {
  LabState s;
  s.period = period;
  if (period == 0) s.fields[lab::arena_rule().name] = {1'000'000, 500'000, 2, 9};
  s.fields["team"] = {0, 5};
  s.robots = {{.robot = 1, .in_shared = {1.0, 0.5, 0}}, {.robot = 9, .in_shared = {-1.0, -0.5, 0}}};
  return s;
}

}  // namespace

TEST_CASE("a state within the rules is not refused") {
  CHECK(why_refused("b", state_of_b(0), state_of_b(0)) == "");
  CHECK(why_refused("b", state_of_b(7), state_of_b(0)) == "");
  LabState owners = state_of_b(7);
  owners.fields["site"] = {3};
  CHECK(why_refused("a", owners, state_of_b(0)) == "position");  // not scaled: a's arena is half as wide
}

TEST_CASE("each lie has a name") {
  struct Lie {
    std::string_view why;
    std::function<void(LabState&)> tell;
  };
  for (const Lie& lie : {
           Lie{"unknown_field", [](LabState& s) { s.fields["other"] = {1}; }},
           Lie{"not_owner", [](LabState& s) { s.fields["site"] = {1}; }},
           Lie{"initial_field", [](LabState& s) { s.fields["once"] = {1}; }},
           Lie{"field_length", [](LabState& s) { s.fields["team"] = {1}; }},
           Lie{"field_value",
               [](LabState& s) {
                 s.fields["team"] = {1, 6};
               }},
           Lie{"field_value",
               [](LabState& s) {
                 s.fields["team"] = {-1, 0};
               }},
           Lie{"robots", [](LabState& s) { s.robots.resize(3); }},
           Lie{"robot", [](LabState& s) { s.robots[1].robot = 10; }},
           Lie{"position", [](LabState& s) { s.robots[0].in_shared.x_m = 1.3; }},
           Lie{"position", [](LabState& s) { s.robots[0].in_shared.y_m = -0.8; }},
       }) {
    LabState state = state_of_b(7);
    lie.tell(state);
    CHECK(why_refused("b", state, state_of_b(0)) == lie.why);
  }
}

TEST_CASE("a lie is told in a sentence") {
  LabState state = state_of_b(7);
  state.fields["team"] = {1, 6};
  CHECK(rules.refusal("b", state, state_of_b(0))->sentence == "field 'team' holds 6, which is not within 0 to 5");
  state = state_of_b(7);
  state.robots[0].in_shared.x_m = 1.3;
  CHECK(rules.refusal("b", state, state_of_b(0))->sentence ==
        "robot 1 is at 0.650, 0.250 m, outside its arena of 1 x 0.5 m");
}

TEST_CASE("a state 0 that does not tell its arena is refused, and nothing is looked up in it") {
  LabState bare = state_of_b(0);
  bare.fields.erase(lab::arena_rule().name);
  CHECK(why_refused("b", bare, bare) == "no_arena");
  CHECK(why_refused("b", state_of_b(7), bare) == "no_arena");
  CHECK(why_refused("c", state_of_b(7), state_of_b(0)) == "no_projection");
}
