#include "lab/robots/robot_words.hpp"

#include <doctest/doctest.h>

using namespace arkmesh;
using namespace std::chrono_literals;
using lab::RobotWords;

TEST_CASE("robot words: at once when it changes, again until it shows, then never") {
  // Proves when a word goes out: on a change, after each interval while the robot does not show it, in each slot apart.
  RobotWords words;
  const hal::ToRobot dark{.robot = 3}, lit{.robot = 3, .kind = 1}, other_slot{.robot = 3, .slot = 1, .kind = 2};
  CHECK(!words.due(100ms, dark, true, 1s));  // as a robot begins
  CHECK(words.due(200ms, lit, false, 1s));
  CHECK(!words.due(1199ms, lit, false, 1s));
  CHECK(words.due(1200ms, lit, false, 1s));
  CHECK(!words.due(9s, lit, true, 1s));
  CHECK(words.due(9s, other_slot, true, 1s));
  CHECK(!words.due(9s, lit, true, 1s));
  CHECK(words.due(9s, dark, true, 1s));
}

TEST_CASE("robot words: another LED than at the change shows that it was heard") {
  // Proves the rule for who does not say what a robot shows.
  RobotWords words;
  const hal::ToRobot word{.robot = 3, .value = 7};
  CHECK(words.due(0s, word, hal::Led::red, 1s));
  CHECK(words.due(1s, word, hal::Led::red, 1s));
  CHECK(!words.due(2s, word, hal::Led::green, 1s));
  CHECK(words.due(3s, word, hal::Led::red, 1s));
}

TEST_CASE("robot words: what a robot may have forgotten is told again, whatever it shows") {
  // Proves that a doubt repeats known words of that robot alone, so often, at the interval, and counts them; and that a
  // robot that begins anew is judged by the LED that it has then.
  RobotWords words;
  const auto due = [&](hal::LabTime now, hal::RobotId robot, std::uint8_t kind, bool shown) {
    return words.due(now, {.robot = robot, .kind = kind}, shown, 1s);
  };
  CHECK(due(0s, 1, 2, true));
  CHECK(due(0s, 4, 2, true));
  CHECK(!due(0s, 7, 0, true));  // never told
  CHECK(words.size() == 2);
  words.doubt(1, 2);
  CHECK(!due(900ms, 1, 2, true));
  CHECK(due(1s, 1, 2, true));
  CHECK(!due(1s, 4, 2, true));
  CHECK(!due(1900ms, 1, 2, true));
  CHECK(due(2s, 1, 2, true));
  CHECK(!due(3s, 1, 2, true));
  CHECK(words.told_again() == 2);
  words.doubt(hal::everyone, RobotWords::for_sure);
  int told = 0;
  for (hal::LabTime now = 4s; now < 14s; now += 100ms)
    told += due(now, 1, 2, true) + due(now, 4, 2, true) + due(now, 7, 0, true);
  CHECK(told == 2 * RobotWords::for_sure);

  // by itself, to those in sight
  words.doubt(hal::everyone, 1);
  std::vector<hal::ToRobot> out;
  const std::vector<hal::Observation> in_sight{{.robot = 1}, {.robot = 4, .age = 1ms}, {.robot = 7}};
  for (hal::LabTime now = 20s; now < 25s; now += 100ms) words.retell(now, in_sight, out);
  REQUIRE(out.size() == 1);
  CHECK(out[0].robot == 1);
  CHECK(out[0].kind == 2);
  words.retell(25s, std::vector<hal::Observation>{{.robot = 4}}, out);
  CHECK(out.size() == 2);

  const hal::ToRobot blue{.robot = 9, .kind = 2};
  CHECK(words.due(0s, blue, hal::Led::red, 1s));
  CHECK(!words.due(1s, blue, hal::Led::blue, 1s));
  words.doubt(hal::everyone, RobotWords::for_sure);
  told = 0;
  for (hal::LabTime now = 2s; now < 12s; now += 1s) told += words.due(now, blue, hal::Led::off, 1s);
  CHECK(told == 10);  // it lies dark, which red was not
  CHECK(!words.due(12s, blue, hal::Led::blue, 1s));
}

TEST_CASE("robot words: an LED that cannot be told shows nothing") {
  // Proves: no word counts as heard because the camera lost sight of the LED, and the first colour after it is no
  // change.
  RobotWords words;
  const hal::ToRobot word{.robot = 3, .value = 7}, other{.robot = 3, .value = 8};
  CHECK(words.due(0s, word, hal::Led::red, 1s));
  CHECK(words.due(1s, word, hal::Led::unknown, 1s));
  CHECK(words.due(2s, word, hal::Led::red, 1s));
  CHECK(words.due(3s, other, hal::Led::unknown, 1s));
  CHECK(words.due(4s, other, hal::Led::red, 1s));
  CHECK(!words.due(5s, other, hal::Led::green, 1s));
}
