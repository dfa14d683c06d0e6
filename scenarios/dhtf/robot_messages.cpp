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
  Told told{DHTF_CLOSED, place.wall_sectors};
  if (!place.in_site)
    told.kind = DHTF_OUTSIDE;
  else if (place.active && led != leaving)
    told = {DHTF_TASK, static_cast<std::uint16_t>(place.timeout_s)};
  told.shown = !needs_repeating(told, led);
  return told;
}

}  // namespace arkmesh::scenarios::dhtf
