#include "lab/robots/robot_words.hpp"

#include <algorithm>

namespace arkmesh::lab {

bool RobotWords::due(hal::LabTime now, const hal::ToRobot& word, bool shown, hal::LabTime again) {
  Last& known = last(word);
  const bool same = known.is(word);
  if (same && ((shown && known.doubts == 0) || now - known.when < again)) return false;
  if (same && known.doubts > 0) ++told_again_;
  known.doubts = std::max(0, known.doubts - 1);
  known.kind = word.kind;
  known.value = word.value;
  known.when = now;
  known.again = again;
  return known.told = true;
}

bool RobotWords::due(hal::LabTime now, const hal::ToRobot& word, hal::Led led, hal::LabTime again) {
  Last& known = last(word);
  if (!known.is(word) || known.doubts == for_sure || known.led == hal::Led::unknown) known.led = led;
  return due(now, word, led != known.led && led != hal::Led::unknown, again);
}

void RobotWords::doubt(hal::RobotId robot, int times) {
  for (auto& [key, known] : last_)
    if (known.told && (robot == hal::everyone || key >> 8 == robot)) {
      known.doubts = std::max(known.doubts, times);
      doubts_ = true;
    }
}

void RobotWords::retell(hal::LabTime now, std::span<const hal::Observation> robots, std::vector<hal::ToRobot>& out) {
  if (!doubts_) return;
  doubts_ = std::ranges::any_of(last_, [](const auto& entry) { return entry.second.doubts > 0; });
  for (const hal::Observation& robot : robots) {
    if (robot.age > hal::LabTime{0}) continue;
    const std::uint64_t first = std::uint64_t{robot.robot} << 8;
    for (auto at = last_.lower_bound(first); at != last_.end() && at->first < first + 256; ++at) {
      const Last& known = at->second;
      const hal::ToRobot word{robot.robot, static_cast<std::uint8_t>(at->first), known.kind, known.value};
      if (known.doubts > 0 && due(now, word, true, known.again)) out.push_back(word);
    }
  }
}

std::size_t RobotWords::size() const {
  return static_cast<std::size_t>(std::ranges::count_if(last_, [](const auto& entry) { return entry.second.told; }));
}

}  // namespace arkmesh::lab
