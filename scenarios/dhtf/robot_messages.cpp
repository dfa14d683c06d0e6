#include "scenarios/dhtf/robot_messages.hpp"

#include "scenarios/dhtf/controller/dhtf_messages.h"

namespace arkmesh::scenarios::dhtf {
namespace {

// Whether a robot that shows `led` may not have heard, or will forget, what it was told.
bool needs_repeating(const Told& told, hal::Led led) {
  switch (told.kind) {
    case DHTF_TASK:
      return led != dwelling;
    case DHTF_CLOSED:
      return led == dwelling || told.value != 0;
    default:
      return led == dwelling || led == leaving || told.value != 0;
  }
}

}  // namespace

Told message_for(const Place& place, hal::Led led) {
  if (!place.in_site) return {DHTF_OUTSIDE, place.wall_sectors};
  if (place.active && led != leaving) return {DHTF_TASK, static_cast<std::uint16_t>(place.timeout_s)};
  return {DHTF_CLOSED, place.wall_sectors};
}

std::optional<hal::ToRobot> next_message(lab::RobotWords& words, hal::LabTime now, hal::RobotId robot,
                                         const Place& place, hal::Led led) {
  const Told told = message_for(place, led);
  return words.next(now, {.robot = robot, .slot = DHTF_SLOT, .kind = told.kind, .value = told.value},
                    !needs_repeating(told, led));
}

}  // namespace arkmesh::scenarios::dhtf
