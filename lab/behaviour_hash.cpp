#include "lab/behaviour_hash.hpp"

#include <limits>

namespace arkmesh::lab {

std::int32_t to_micro(double value) {
  constexpr double limit = std::numeric_limits<std::int32_t>::max();
  const double micro = value * 1e6;
  if (!(micro > -limit)) return -std::numeric_limits<std::int32_t>::max();  // also not-a-number
  if (micro > limit) return std::numeric_limits<std::int32_t>::max();
  // as std::round() does, without a call
  const auto whole = static_cast<std::int32_t>(micro);
  const double rest = micro - whole;
  return whole + static_cast<int>(rest >= 0.5) - static_cast<int>(rest <= -0.5);
}

void BehaviourHash::add(const hal::PoseFrame& frame) {
  const auto pair = [](std::int32_t a, std::int32_t b) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
  };
  add(frame.number);
  for (const hal::Observation& s : frame.robots) {
    add(pair(to_micro(s.pose.x_m), to_micro(s.pose.y_m)));
    add(pair(to_micro(s.pose.heading_rad), s.robot << 8 | static_cast<std::int32_t>(s.led)));
  }
  for (const hal::ObjectObservation& s : frame.objects) {
    add(pair(to_micro(s.pose.x_m), to_micro(s.pose.y_m)));
    add(pair(to_micro(s.pose.heading_rad), -1));
  }
}

std::uint64_t joint_hash(const std::map<std::string, std::uint64_t>& by_lab) {
  BehaviourHash all;
  for (const auto& [lab, hash] : by_lab) all.add(hash);
  return all.value();
}

}  // namespace arkmesh::lab
