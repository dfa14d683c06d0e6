// How robots spell their ids in light: digits in base 3, least significant first, then a check word. Red, green and
// blue are the digits 0, 1 and 2: of all colours the three that a camera confuses least.
// hal/platforms/kilobot/firmware/arkmesh_id.h is the robots' side.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/types.hpp"
#include "tracker/follow/track.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::tracker {

inline constexpr int max_id_digits = 11;  // enough for 16 bits
inline constexpr int check_digits = 3;
inline constexpr std::uint8_t question_type = 118, ark_runtime_type = 119, ark_initial_type = 120;
inline constexpr hal::RobotId largest_spelled_id = 65534;  // 65535 is an erased memory

// Digits that ids up to `largest` need, 1..11.
int id_digits(hal::RobotId largest);

// Numbers of digits in the order in which they are asked for: 0..n-1 of the id, 11..13 of the check word.
std::span<const std::uint8_t> digit_order(int digits);

// 0..2, or nothing for a colour that is no digit.
constexpr std::optional<std::uint8_t> digit_of(hal::Led led) {
  switch (led) {
    case hal::Led::red:
      return std::uint8_t{0};
    case hal::Led::green:
      return std::uint8_t{1};
    case hal::Led::blue:
      return std::uint8_t{2};
    default:
      return std::nullopt;
  }
}

// What the LED of a robot shows that has been asked and so shows red, green or blue: in a neighbour's light that is
// clearer than which of all colours it may be. Off when it is not clear, or when it clearly is none of them.
hal::Led answer_of(const Track& track);

// What the robot shows for digit `number` of digit_order().
hal::Led spelled(hal::RobotId robot, int number);

// The id that digits in the order of digit_order() spell; nothing when the check word is not theirs. Any one wrong
// digit is noticed, an LED that never changes is never an id, and other errors pass in one of 23 cases.
std::optional<hal::RobotId> id_of(std::span<const std::uint8_t> digits);

// Who is asked.
struct Audience {
  enum class Kind : std::uint8_t { everybody = 1, range = 2, list = 3 };
  Kind kind = Kind::everybody;
  std::array<hal::RobotId, 4> robots{};  // range: first and last; list: ids, the rest nobody
  bool includes(hal::RobotId robot) const;
};
inline constexpr hal::RobotId nobody = 65535;

// The smallest audience with all of `wanted` (ascending, not empty) and nobody of `spared` (ascending); four of them,
// from `turn` on in rotation, when they need more than one message.
Audience audience_for(std::span<const hal::RobotId> wanted, std::span<const hal::RobotId> spared, std::size_t turn);

// Broadcasts.
Question digit_question(const Audience& audience, int number);
Question end_of_questions();
// ARK's, type 119 or 120; `robot` 65535 ends.
Question ark_question(std::uint8_t type, hal::RobotId robot);

}  // namespace arkmesh::tracker
