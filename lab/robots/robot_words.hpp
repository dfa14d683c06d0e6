// Words that robots have to know: told at once when they change, and again at an interval while the robot does not show
// it. Airtime is scarce, so a robot that knows is left alone. Kinds that exclude each other share a slot. The arena
// shares the airtime between what is said.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::lab {

class RobotWords {
 public:
  // Whether `word` has to go out now, so that a robot knows it; then it counts as told. `shown`: it shows that it
  // knows, or need not be told again. A robot that was never told counts as told kind 0, value 0, at time 0, as
  // programs are when they begin. `again`: lab time after which a word is said once more.
  bool due(hal::LabTime now, const hal::ToRobot& word, bool shown, hal::LabTime again);
  // The same for a robot whose program shows in its LED only that something has changed: a word counts as shown when
  // the LED is another one than when the word changed; an unknown one shows nothing.
  bool due(hal::LabTime now, const hal::ToRobot& word, hal::Led led, hal::LabTime again);

  // A robot, or `everyone`, may have missed what it was told, or forgotten it: it is told so often again, at that
  // interval, whatever it shows, and whether due() is asked or not.
  void doubt(hal::RobotId robot, int times);
  // Appends what is to be told again of that to robots in sight.
  void retell(hal::LabTime now, std::span<const hal::Observation> robots, std::vector<hal::ToRobot>& out);
  static constexpr int for_sure = 3;  // a robot may miss every tenth message
  // How often a word went out because of that.
  std::uint64_t told_again() const { return told_again_; }
  // Words that a doubt of all would send, each time.
  std::size_t size() const;

 private:
  struct Last {
    std::uint8_t kind = 0;
    std::uint32_t value = 0;
    hal::LabTime when{0};
    hal::LabTime again{0};
    hal::Led led = hal::Led::off;  // when the word changed, or became doubtful
    bool told = false;
    int doubts = 0;
    bool is(const hal::ToRobot& word) const { return kind == word.kind && value == word.value; }
  };
  Last& last(const hal::ToRobot& word) { return last_[static_cast<std::uint64_t>(word.robot) << 8 | word.slot]; }

  std::map<std::uint64_t, Last> last_;  // by robot and slot
  bool doubts_ = false;                 // of any, since retell() found none
  std::uint64_t told_again_ = 0;
};

}  // namespace arkmesh::lab
