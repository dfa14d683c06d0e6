// What DHTF tells a robot, and when.
#include "scenarios/dhtf/robot_messages.hpp"

#include <doctest/doctest.h>

#include "lab/robots/robot_words.hpp"
#include "scenarios/dhtf/controller/dhtf_messages.h"

using namespace arkmesh;
using namespace arkmesh::scenarios::dhtf;
using hal::Led;
using namespace std::chrono_literals;

namespace {

constexpr hal::LabTime tenth{100'000};
constexpr Place outside{}, near_wall{.wall_sectors = 0x0f},
    waiting_task{.in_site = true, .active = true, .timeout_s = 40}, closed{.in_site = true, .timeout_s = 40},
    closed_near_wall{.in_site = true, .timeout_s = 40, .wall_sectors = 0xf0};

std::optional<hal::ToRobot> next_message(lab::RobotWords& words, hal::LabTime now, hal::RobotId robot,
                                         const Place& place, Led led) {
  const Told told = message_for(place, led);
  const hal::ToRobot word{.robot = robot, .kind = told.kind, .value = told.value};
  return words.due(now, word, told.shown, 1s) ? std::optional(word) : std::nullopt;
}

// How many messages a robot gets in ten seconds at the same place, showing the same LED, after those of the first
// frame.
int repeats(const Place& place, Led led) {
  lab::RobotWords messages;
  next_message(messages, hal::LabTime(0), 3, place, led);
  int n = 0;
  for (int frame = 1; frame <= 100; ++frame) n += next_message(messages, frame * tenth, 3, place, led).has_value();
  return n;
}

}  // namespace

TEST_CASE("dhtf messages: contents of the messages") {
  // The whole table of place and LED: kind and value.
  struct Row {
    Place place;
    Led led;
    int kind;
    int value;
  };
  for (const Row& row : {Row{outside, walking, DHTF_OUTSIDE, 0}, Row{near_wall, walking, DHTF_OUTSIDE, 0x0f},
                         Row{near_wall, leaving, DHTF_OUTSIDE, 0x0f}, Row{outside, dwelling, DHTF_OUTSIDE, 0},
                         Row{waiting_task, walking, DHTF_TASK, 40}, Row{waiting_task, dwelling, DHTF_TASK, 40},
                         Row{waiting_task, Led::off, DHTF_TASK, 40}, Row{waiting_task, leaving, DHTF_CLOSED, 0},
                         Row{closed, walking, DHTF_CLOSED, 0}, Row{closed, dwelling, DHTF_CLOSED, 0},
                         Row{closed_near_wall, leaving, DHTF_CLOSED, 0xf0}}) {
    const Told told = message_for(row.place, row.led);
    CHECK(told.kind == row.kind);
    CHECK(told.value == row.value);
  }
}

TEST_CASE("dhtf messages: changes at once, addressed") {
  // A robot hears of every change in the frame in which it is seen, in the one slot, and others are left alone.
  lab::RobotWords messages;
  CHECK(!next_message(messages, 0 * tenth, 7, outside, walking));
  const auto wall = next_message(messages, 1 * tenth, 7, near_wall, walking);
  REQUIRE(wall);
  CHECK(wall->robot == 7);
  CHECK(wall->kind == DHTF_OUTSIDE);
  CHECK(wall->value == 0x0f);
  CHECK(!next_message(messages, 1 * tenth, 6, outside, walking));
  CHECK(next_message(messages, 2 * tenth, 7, waiting_task, walking)->kind == DHTF_TASK);
  CHECK(!next_message(messages, 3 * tenth, 7, waiting_task, dwelling));
  CHECK(next_message(messages, 4 * tenth, 7, closed, dwelling)->kind == DHTF_CLOSED);
  CHECK(!next_message(messages, 5 * tenth, 7, closed, walking));
  CHECK(next_message(messages, 6 * tenth, 7, outside, walking)->kind == DHTF_OUTSIDE);
}

TEST_CASE("dhtf messages: repeats once a second until the LED shows that it was heard") {
  // Ten repeats in ten seconds where a message seems lost or a wall is near; none where the robot knows.
  CHECK(repeats(waiting_task, walking) == 10);
  CHECK(repeats(waiting_task, Led::off) == 10);
  CHECK(repeats(waiting_task, dwelling) == 0);
  CHECK(repeats(waiting_task, leaving) == 0);
  CHECK(repeats(closed, dwelling) == 10);
  CHECK(repeats(closed, walking) == 0);
  CHECK(repeats(outside, leaving) == 10);
  CHECK(repeats(outside, dwelling) == 10);
  CHECK(repeats(outside, walking) == 0);
  CHECK(repeats(near_wall, walking) == 10);
  CHECK(repeats(closed_near_wall, leaving) == 10);
}
