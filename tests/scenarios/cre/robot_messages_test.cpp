// What CRE's robots are told: readings, walls, and which flying robot a ground robot hears.
#include "scenarios/cre/robot_messages.hpp"

#include <doctest/doctest.h>

#include <numbers>

#include "scenarios/cre/controller/cre_messages.h"
#include "scenarios/wall_sensor.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
namespace cre = scenarios::cre;
using cre::Region;

namespace {

constexpr double half_turn = std::numbers::pi;

}  // namespace

TEST_CASE("cre messages: readings") {
  // Densities are shares of the places in sight, in 1/30; where no place is, there is no density.
  const hal::ToRobot told = cre::reading(7, {.active = {1, 7}, .places = {5, 10}}, CRE_WALL_LEFT);
  CHECK(told.robot == 7);
  CHECK(told.slot == CRE_READING_SLOT);
  CHECK(told.kind == CRE_WALL_LEFT);
  CHECK(told.value == (6 << 5 | 21));
  CHECK(cre::reading(7, {.active = {0, 3}, .places = {0, 3}}, 0).value == (CRE_NO_PLACE << 5 | CRE_FULL));
  // The greatest value fits a message.
  CHECK(cre::reading(7, {.active = {0, 0}, .places = {0, 0}}, 3).value == 1023);
}

TEST_CASE("cre messages: walls") {
  // A robot that heads for a wall is told on which side it is; one that heads along it or away is not.
  const auto wall = [](double y_m, double heading) {
    return cre::wall_of(scenarios::blocked_sectors({0, y_m, heading}, 2, 2, 0.068));
  };
  CHECK(wall(0, half_turn / 2) == CRE_NO_WALL);
  CHECK(wall(0.95, half_turn / 2) == CRE_WALL_AHEAD);
  CHECK(wall(0.95, half_turn / 2 - 0.5) == CRE_WALL_LEFT);
  CHECK(wall(0.95, half_turn / 2 + 0.5) == CRE_WALL_RIGHT);
  CHECK(wall(0.95, -half_turn / 2) == CRE_NO_WALL);
  CHECK(wall(0.95, -half_turn / 4) == CRE_NO_WALL);
}

TEST_CASE("cre messages: the LED tells a flying robot's opinion") {
  CHECK(cre::opinion_of(hal::Led::red) == Region::north);
  CHECK(cre::opinion_of(hal::Led::blue) == Region::south);
  for (hal::Led led : {hal::Led::off, hal::Led::green, hal::Led::white}) CHECK(!cre::opinion_of(led));
}

TEST_CASE("cre messages: who is heard") {
  // The nearest flying robot within reach that is outside its region; in a mirror the mirrored one.
  const std::vector<cre::Speaker> speakers = {{{0, -0.1}, Region::south},  // in its region: silent
                                              {{0, 0.1}, Region::south},
                                              {{0.15, 0.1}, Region::south},
                                              {{0.1, -0.1}, Region::north},
                                              {{0.5, 0.5}, Region::south}};
  const auto heard = [&](double x, double y) { return cre::nearest_speaker(speakers, {x, y}, 0.2); };
  CHECK(heard(0, 0.05) == &speakers[1]);
  CHECK(heard(0, -0.1) == &speakers[3]);  // the one at the same place is silent
  CHECK(heard(0.14, 0.1) == &speakers[2]);
  CHECK(heard(0.5, 0.301) == &speakers[4]);
  CHECK(heard(0.5, 0.299) == nullptr);
  CHECK(cre::nearest_speaker({}, {0, 0}, 10) == nullptr);
  // Over the border a robot falls silent.
  for (double y : {-0.5, -0.001, 0.001, 0.5})
    for (Region region : cre::both_regions) {
      const std::vector<cre::Speaker> one = {{{0, y}, region}};
      CHECK((cre::nearest_speaker(one, {0, y}, 0.2) != nullptr) == ((region == Region::south) == (y > 0)));
    }
}

TEST_CASE("cre messages: when a ground robot is told") {
  // What it hears only while it walks, at most once in `repeat`, with its heading.
  cre::GroundMessages messages(1s);
  const cre::Speaker speaker{{0, 0.5}, Region::south};
  const hal::Pose at{0, 0.4, half_turn / 2};
  CHECK(!messages.heard(0s, 3, at, hal::Led::off, nullptr));
  CHECK(!messages.heard(0s, 3, at, hal::Led::white, &speaker));
  CHECK(!messages.heard(0s, 3, at, hal::Led::blue, &speaker));
  const auto told = messages.heard(0s, 3, at, hal::Led::off, &speaker);
  REQUIRE(told);
  CHECK(told->robot == 3);
  CHECK(told->slot == CRE_HEARD_SLOT);
  CHECK(told->kind == CRE_HEARD_SOUTH);
  CHECK(told->value == CRE_TURN / 4);
  CHECK(!messages.heard(900ms, 3, at, hal::Led::off, &speaker));
  CHECK(messages.heard(1s, 3, at, hal::Led::off, &speaker));
  CHECK(messages.heard(1s, 4, at, hal::Led::off, &speaker));
  // The compass at the turn's ends.
  CHECK(messages.heard(0s, 10, {0, 0, half_turn}, hal::Led::off, &speaker)->value == CRE_TURN / 2);
  CHECK(messages.heard(0s, 11, {0, 0, -1e-4}, hal::Led::off, &speaker)->value == 0);
  CHECK(messages.heard(0s, 12, {0, 0, -half_turn / 2}, hal::Led::off, &speaker)->value == 3 * CRE_TURN / 4);
}
