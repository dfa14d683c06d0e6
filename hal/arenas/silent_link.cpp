// Checks every message as a link to real robots would.
#include "hal/arenas/silent_link.hpp"

#include <algorithm>
#include <array>

#include "hal/robot/set_point.hpp"

namespace arkmesh::hal {

const char* refusal(const ArenaInfo& info, const ToRobot& message) {
  if (message.whole) {
    if (info.whole == WholeMessages::to_nobody) return "to_robots.refused.whole";
    if (message.whole->type > 127) return "to_robots.refused.type";
    if (message.robot == everyone) return nullptr;
    if (info.whole != WholeMessages::to_each) return "to_robots.refused.whole_to_one";
  }
  if (!std::binary_search(info.robots.begin(), info.robots.end(), message.robot))
    return "to_robots.refused.unknown_robot";
  if (message.whole) return nullptr;
  if (message.robot > info.max_robot) return "to_robots.refused.robot_not_addressable";
  if (set_point_in(info, message)) return nullptr;
  if (message.kind >= info.kinds) return "to_robots.refused.kind";
  if (message.value >= info.values) return "to_robots.refused.value";
  return nullptr;
}

const char* refusal(const ArenaInfo& info, const FleetCommand& command) {
  // in the order of FleetCommand::Kind
  static constexpr std::array reasons = {"fleet_command.refused.run",      "fleet_command.refused.pause",
                                         "fleet_command.refused.reset",    "fleet_command.refused.sleep",
                                         "fleet_command.refused.voltage",  "fleet_command.refused.charge",
                                         "fleet_command.refused.broadcast"};
  static_assert(reasons.size() == static_cast<std::size_t>(FleetCommand::Kind::broadcast) + 1);
  if (std::ranges::find(info.commands, command.kind) != info.commands.end()) return nullptr;
  return reasons.at(static_cast<std::size_t>(command.kind));
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
