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

const char* refusal(const ArenaInfo& info, const FleetCommand& command) {
  if (std::ranges::find(info.commands, command.kind) != info.commands.end()) return nullptr;
  using Kind = FleetCommand::Kind;
  switch (command.kind) {
    case Kind::run:
      return "fleet_command.refused.run";
    case Kind::pause:
      return "fleet_command.refused.pause";
    case Kind::reset:
      return "fleet_command.refused.reset";
    case Kind::sleep:
      return "fleet_command.refused.sleep";
    case Kind::voltage:
      return "fleet_command.refused.voltage";
    case Kind::charge:
      return "fleet_command.refused.charge";
    case Kind::broadcast:
      return "fleet_command.refused.broadcast";
  }
  return "fleet_command.refused.unknown";
}

void SilentLink::offer(std::span<const ToRobot> newest) {
  for (const ToRobot& message : newest) {
    ++airtime_.offered;
    if (const char* reason = refusal(info_, message)) {
      ++airtime_.refused;
      counters_.add(reason);
    } else {
      ++airtime_.not_sent;
    }
  }
}

void SilentLink::command(const FleetCommand& command) {
  const char* const reason = refusal(info_, command);
  counters_.add(reason ? reason : "fleet_command.not_sent");
}

}  // namespace arkmesh::hal
