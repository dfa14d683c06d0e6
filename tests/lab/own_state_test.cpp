// What a lab's own state holds, and what enters the hash.
#include "lab/own_state.hpp"

#include <doctest/doctest.h>

using namespace arkmesh;

namespace {

const hal::PoseFrame one_frame{.stamp = hal::LabTime(100'000),
                               .number = 1,
                               .robots = {{.robot = 3, .pose = {0.1234567, -0.2, 1.5}, .led = hal::Led::green}}};

const std::map<std::string, std::string, std::less<>> settings = {{"run.seed", "1"}};

lab::LabData data() {
  lab::LabData d;
  d.name = "a";
  d.projections = {{"a", {.shift_x_m = 1, .scale = 2}}};
  d.rules = {{.name = "once", .length = 1, .initial_only = true}, {.name = "team", .length = 1}};
  d.fields = {{"once", {5}}, {"team", {6}}, {"undeclared", {7}}};
  return d;
}

}  // namespace

TEST_CASE("an own state holds the newest robots, projected and rounded as others decode them") {
  lab::OwnState own(settings);
  own.add({});
  own.add(one_frame);
  const lab::LabState state = own.at_boundary(0, data());
  REQUIRE(state.robots.size() == 1);
  CHECK(state.robots[0].robot == 3);
  CHECK(state.robots[0].in_shared.x_m == 1246913 * 1e-6);
  CHECK(state.robots[0].in_shared.y_m == -400000 * 1e-6);
  CHECK(state.robots[0].led == hal::Led::green);
  CHECK(state.hash == own.hash());
}

TEST_CASE("fields are part of a state, initial ones and settings of state 0 only") {
  // What was not declared is there to be refused.
  lab::OwnState own(settings);
  const lab::LabState first = own.at_boundary(0, data()), second = own.at_boundary(1, data());
  CHECK(first.fields.size() == 3);
  // the field "team" and "once" as they are declared, which labs must have alike, and that this lab tells such
  CHECK(first.settings.size() == 4);
  CHECK(first.settings.contains("field.team"));
  CHECK(second.fields.size() == 2);
  CHECK(second.fields.contains("team"));
  CHECK(second.settings.empty());
}

TEST_CASE("the hash is over what robots and sites did, not over settings and the owner's choices") {
  const auto hash = [](const hal::PoseFrame& seen, const lab::LabData& d, const char* seed = "1") {
    lab::OwnState own(std::map<std::string, std::string, std::less<>>{{"run.seed", seed}});
    own.add(seen);
    return own.at_boundary(0, d).hash;
  };
  const std::uint64_t reference = hash(one_frame, data());
  lab::LabData other = data();
  other.fields["once"] = {4};
  CHECK(hash(one_frame, other, "2") == reference);
  other.fields["team"] = {4};
  CHECK(hash(one_frame, other) != reference);
  lab::LabData drawn = data();
  drawn.streams.emplace("sites", hal::RandomStream(1, "a/sites")).first->second.next();
  CHECK(hash(one_frame, drawn) != reference);
  hal::PoseFrame moved = one_frame;
  moved.robots[0].pose.x_m += 1e-6;
  CHECK(hash(moved, data()) != reference);
}

TEST_CASE("the fingerprint of settings tells every difference") {
  // Also one that moves a letter from a key to its value.
  const auto hash = [](std::map<std::string, std::string, std::less<>> all) {
    return lab::OwnState(std::move(all)).settings_hash();
  };
  CHECK(hash({{"a", "1"}, {"b", "2"}}) == hash({{"b", "2"}, {"a", "1"}}));
  const std::map<std::string, std::string, std::less<>> others[] = {{},           {{"a", "1"}},           {{"a", "2"}},
                                                                    {{"a1", ""}}, {{"a", "1"}, {"", ""}}, {{"b", "1"}}};
  for (const auto& each : others)
    for (const auto& other : others) CHECK((hash(each) == hash(other)) == (each == other));
}
