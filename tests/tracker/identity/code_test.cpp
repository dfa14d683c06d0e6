// Ids in light.
#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "tracker/identity/id_code.hpp"

using namespace arkmesh;
using namespace arkmesh::tracker;

namespace {

std::vector<std::uint8_t> digits_of(hal::RobotId robot, int digits) {
  std::vector<std::uint8_t> out;
  for (const std::uint8_t number : digit_order(digits)) out.push_back(*digit_of(spelled(robot, number)));
  return out;
}

}  // namespace

TEST_CASE("identity: every id is read as it is spelled, and not when it is cut short") {
  // All ids of 16 bits but the erased one; with seven digits a longer id passes as another one only where the part cut
  // off is 23.
  int wrong = 0, passed_short = 0;
  for (hal::RobotId robot = 0; robot <= largest_spelled_id; ++robot) {
    wrong += id_of(digits_of(robot, max_id_digits)) != robot;
    if (robot > 2186) passed_short += id_of(digits_of(robot, 7)).has_value();
  }
  CHECK(wrong == 0);
  CHECK(passed_short == 2187);
  CHECK_FALSE(id_of(digits_of(65535, max_id_digits)));
}

TEST_CASE("identity: digits needed") {
  // 3^n ids have n digits; 16 bits have eleven.
  const std::pair<hal::RobotId, int> cases[] = {{0, 1},   {2, 1},   {3, 2},    {8, 2},    {9, 3},    {99, 5},
                                                {242, 5}, {243, 6}, {1022, 7}, {2186, 7}, {2187, 8}, {65534, 11}};
  for (const auto& [largest, digits] : cases) CHECK(id_digits(largest) == digits);
}

TEST_CASE("identity: one wrong digit is always noticed, an LED that never changes is no id") {
  // Every single error of every id up to 2186; three constant colours in all lengths; a robot that stops hearing at any
  // digit and keeps its colour passes never where that colour stands in all of the check word.
  for (hal::RobotId robot = 0; robot < 2187; ++robot) {
    const auto right = digits_of(robot, 7);
    for (std::size_t i = 0; i < right.size(); ++i) {
      auto wrong = right;
      for (int by = 1; by <= 2; ++by) {
        wrong[i] = static_cast<std::uint8_t>((right[i] + by) % 3);
        CHECK_FALSE(id_of(wrong));
      }
    }
    for (std::size_t from = 1; from <= 7; ++from) {
      auto stuck = right;
      std::fill(stuck.begin() + static_cast<long>(from), stuck.end(), right[from - 1]);
      CHECK_FALSE(id_of(stuck));
    }
  }
  for (int digits = 1; digits <= max_id_digits; ++digits)
    for (std::uint8_t colour = 0; colour < 3; ++colour)
      CHECK_FALSE(id_of(std::vector<std::uint8_t>(static_cast<std::size_t>(digits + check_digits), colour)));
  CHECK_FALSE(id_of({}));
}

TEST_CASE("identity: an audience is as small as one message can say") {
  // Up to four by name; more as a range when nobody else lies in it; else four of them in turn.
  const std::vector<hal::RobotId> two = {3, 900}, five = {10, 11, 12, 13, 14}, others = {1, 2, 12, 20};
  const Audience list = audience_for(two, others, 0);
  CHECK(list.kind == Audience::Kind::list);
  CHECK(list.includes(3));
  CHECK(list.includes(900));
  CHECK_FALSE(list.includes(4));
  CHECK_FALSE(list.includes(nobody));
  const std::vector<hal::RobotId> outside = {9, 15};
  const Audience range = audience_for(five, outside, 0);
  CHECK(range.kind == Audience::Kind::range);
  for (hal::RobotId robot = 0; robot < 30; ++robot) CHECK(range.includes(robot) == (robot >= 10 && robot <= 14));
  std::vector<int> asked(5, 0);
  for (std::size_t turn = 0; turn < 20; turn += 4) {
    const Audience part = audience_for(five, others, turn);
    CHECK(part.kind == Audience::Kind::list);
    for (std::size_t i = 0; i < 5; ++i) asked[i] += part.includes(five[i]);
  }
  for (int times : asked) CHECK(times == 4);
}

TEST_CASE("identity: questions on the air") {
  // Byte for byte, with checksums that the message's own function confirms.
  const auto everybody = digit_question({}, 12);
  CHECK(everybody.type == 118);
  CHECK(everybody.data == std::array<std::uint8_t, 9>{0x40 | 12});
  const auto range = digit_question({.kind = Audience::Kind::range, .robots = {258, 1022}}, 3);
  CHECK(range.data == std::array<std::uint8_t, 9>{0x80 | 3, 1, 2, 3, 254});
  const auto list = digit_question({.kind = Audience::Kind::list, .robots = {1, 515, nobody, nobody}}, 0);
  CHECK(list.data == std::array<std::uint8_t, 9>{0xC0, 0, 1, 2, 3, 255, 255, 255, 255});
  CHECK(end_of_questions().data == std::array<std::uint8_t, 9>{});
  const auto ark = ark_question(ark_initial_type, 1022);
  CHECK(ark.type == 120);
  CHECK(ark.data == std::array<std::uint8_t, 9>{3, 254});
}
