#include "hal/robot/set_point.hpp"

#include <algorithm>

namespace arkmesh::hal {

ToRobot to_robot(RobotId robot, const SetPoint& wheels) {
  const auto bits = [](int mm_s) { return static_cast<std::uint32_t>(std::clamp(mm_s, -2047, 2047) + 2048); };
  return {.robot = robot, .slot = set_point_slot, .value = bits(wheels.left_mm_s) << 12 | bits(wheels.right_mm_s)};
}

std::optional<SetPoint> set_point_in(const RobotKind& robot, const ToRobot& word) {
  if (!robot.can_be_driven() || word.slot != set_point_slot || word.whole || word.kind != 0) return {};
  const int fastest = static_cast<int>(1000 * robot.drive.speed_m_s);
  const auto speed = [&](std::uint32_t bits) { return std::clamp(static_cast<int>(bits) - 2048, -fastest, fastest); };
  return SetPoint{speed(word.value >> 12 & 0xFFF), speed(word.value & 0xFFF)};
}

}  // namespace arkmesh::hal
