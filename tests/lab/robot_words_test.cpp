#include "lab/robots/robot_words.hpp"

#include <doctest/doctest.h>

using namespace arkmesh;
using namespace std::chrono_literals;
using lab::RobotWords;

TEST_CASE("robot words: at once when it changes, again until it shows, then never") {
  // Proves when a word goes out: on a change, after each interval while the robot does not show it, in each slot apart.
  RobotWords words(1s);
  const hal::ToRobot dark{.robot = 3}, lit{.robot = 3, .kind = 1}, other_slot{.robot = 3, .slot = 1, .kind = 2};
  CHECK(!words.next(100ms, dark, true));  // as a robot begins
  CHECK(words.next(200ms, lit, false));
  CHECK(!words.next(1199ms, lit, false));
  CHECK(words.next(1200ms, lit, false));
  CHECK(!words.next(9s, lit, true));
  CHECK(words.next(9s, other_slot, true));
  CHECK(!words.next(9s, lit, true));
  CHECK(words.next(9s, dark, true));
}

TEST_CASE("robot words: another LED than at the change shows that it was heard") {
  // Proves the rule for who does not say what a robot shows.
  RobotWords words(1s);
  const hal::ToRobot word{.robot = 3, .value = 7};
  CHECK(words.next(0s, word, hal::Led::red));
  CHECK(words.next(1s, word, hal::Led::red));
  CHECK(!words.next(2s, word, hal::Led::green));
  CHECK(words.next(3s, word, hal::Led::red));
}
