// Robots of other labs as virtual sensors take them: not at all, counted, or as obstacles.
#include "scenarios/kit/others.hpp"

#include <doctest/doctest.h>

#include <memory>

#include "lab/testing/lab_double.hpp"

namespace arkmesh::scenarios::kit {
namespace {

struct Idle final : lab::Scenario {
  void begin(lab::Lab&) override {}
  void on_poses(lab::Lab&, const hal::PoseFrame&) override {}
  void on_period(lab::Lab&) override {}
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}
  bool finished(const lab::Lab&) const override { return false; }
};

}  // namespace

TEST_CASE("kit: robots of other labs are what sensors.presence says, where they are in this arena") {
  lab::WorldDouble labs({{"a", 1, {}}, {"b", 1, {.shift_x_m = 0.3}}}, "a");
  labs.begin([](const std::string&) { return std::make_unique<Idle>(); });
  hal::PoseFrame frame;
  frame.robots.push_back({0, {0.1, 0.2, 0}});
  labs["a"].frame(frame);
  labs["b"].frame(frame);
  labs.boundary();
  using Presence = lab::SensorConfig::Presence;
  for (const Presence presence : {Presence::none, Presence::seen, Presence::no_walk}) {
    labs["a"].data.sensors = {.presence = presence, .no_walk_m = 0.05};
    const auto seen = others_in(labs["a"].lab);
    const auto zones = no_walk_zones(labs["a"].lab);
    CHECK(seen.size() == (presence == Presence::none ? 0 : 1));
    CHECK(zones.size() == (presence == Presence::no_walk ? 1 : 0));
    if (!seen.empty()) CHECK(seen[0].place.x_m == doctest::Approx(0.4));
    if (!zones.empty()) CHECK(zones[0].radius_m == 0.05);
    // unless given: as near as bodies let robots here come to each other
    labs["a"].data.sensors.no_walk_m = 0;
    labs["a"].data.arena.body_radius_m = 0.056;
    for (const auto& zone : no_walk_zones(labs["a"].lab)) CHECK(zone.radius_m == 0.112);
  }
}

}  // namespace arkmesh::scenarios::kit
