// Where robots and their infrared medium meet, once a tick.
#pragma once

#include <cstdint>
#include <vector>

#include "sim_ode/contact_world.hpp"
#include "sim_ode/host/turns/reception.hpp"
#include "sim_ode/infrared_medium.hpp"

namespace arkmesh::sim_ode {

// After all robots' turns of tick `number`: the robots' offers go to the medium, each outcome to its robot, the robot's
// reply to the medium. `heard` becomes what robots receive in this tick. `Host`: RobotHost, or RobotGroups. Throws
// ProgramFault.
template <class Host>
void exchange_infrared(std::int64_t number, const ContactWorld& world, Host& host, InfraredMedium& medium,
                       std::vector<Reception>& heard) {
  medium.begin_tick(number, world, host.offers());
  while (const std::optional<Outcome> outcome = medium.next()) {
    if (const int soon = medium.soon(); soon >= 0) host.fetch_memory(soon);
    const Reply reply = host.send_turn(*outcome);
    if (!reply.message) continue;
    if (outcome->channel == Outcome::Channel::busy)
      medium.back_off(reply.back_off_us);
    else
      medium.send(*reply.message);
  }
  medium.end_tick(heard);
}

}  // namespace arkmesh::sim_ode
