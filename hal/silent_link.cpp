// Checks every message as a link to real robots would.
#include "hal/silent_link.hpp"

#include <algorithm>

namespace arkmesh::hal {

const char* refusal(const ArenaInfo& info, const ToRobot& message) {
  if (!std::binary_search(info.robots.begin(), info.robots.end(), message.robot))
    return "to_robots.refused.unknown_robot";
  if (message.robot > info.max_robot) return "to_robots.refused.robot_not_addressable";
  if (message.kind >= info.kinds) return "to_robots.refused.kind";
  if (message.value >= info.values) return "to_robots.refused.value";
  return nullptr;
}

Airtime SilentLink::offer(std::span<const ToRobot> newest) {
  for (const ToRobot& message : newest) {
    ++airtime_.offered;
    if (const char* reason = refusal(info_, message)) {
      ++airtime_.refused;
      counters_.add(reason);
    } else {
      ++airtime_.not_sent;
    }
  }
  return airtime_;
}

void SilentLink::command(const FleetCommand&) {
  counters_.add("fleet_command.not_sent");
}

}  // namespace arkmesh::hal
