// What robots have to be told, until they show that they know: at once when it changes, and again at an interval while
// the robot does not show it. Airtime is scarce, so a robot that knows is left alone. Kinds that exclude each other
// share a slot. The arena shares the airtime between what is offered.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>

#include "hal/types.hpp"

namespace arkmesh::lab {

class RobotWords {
 public:
  // `again`: lab time after which a word is said once more.
  explicit RobotWords(hal::LabTime again) : again_(again) {}
  // The message to send now, if any, so that a robot knows `word`. `shown`: it shows that it knows, or need not be told
  // again. A robot that was never told counts as told kind 0, value 0, at time 0, as programs are when they begin.
  std::optional<hal::ToRobot> next(hal::LabTime now, const hal::ToRobot& word, bool shown);
  // The same for a robot whose program shows in its LED only that something has changed: a word counts as shown when
  // the LED is another one than when the word changed.
  std::optional<hal::ToRobot> next(hal::LabTime now, const hal::ToRobot& word, hal::Led led);

 private:
  struct Last {
    std::uint8_t kind = 0;
    std::uint32_t value = 0;
    hal::LabTime when{0};
    hal::Led led = hal::Led::off;  // when the word changed
  };
  Last& last(const hal::ToRobot& word) { return last_[static_cast<std::uint64_t>(word.robot) << 8 | word.slot]; }

  hal::LabTime again_;
  std::unordered_map<std::uint64_t, Last> last_;  // by robot and slot; looked up only, so its order does not matter
};

}  // namespace arkmesh::lab
