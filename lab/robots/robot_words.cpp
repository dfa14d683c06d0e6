#include "lab/robots/robot_words.hpp"

namespace arkmesh::lab {

std::optional<hal::ToRobot> RobotWords::next(hal::LabTime now, const hal::ToRobot& word, bool shown) {
  Last& known = last(word);
  const bool changed = word.kind != known.kind || word.value != known.value;
  if (!changed && (shown || now - known.when < again_)) return std::nullopt;
  known.kind = word.kind;
  known.value = word.value;
  known.when = now;
  return word;
}

std::optional<hal::ToRobot> RobotWords::next(hal::LabTime now, const hal::ToRobot& word, hal::Led led) {
  Last& known = last(word);
  if (word.kind != known.kind || word.value != known.value) known.led = led;
  return next(now, word, led != known.led);
}

}  // namespace arkmesh::lab
