// Where robots and their infrared medium meet, once a tick.
#pragma once

#include <cstdint>
#include <vector>

#include "sim_ode/contact_world.hpp"
#include "sim_ode/host/robot_host.hpp"
#include "sim_ode/host/turns/reception.hpp"
#include "sim_ode/infrared_medium.hpp"

namespace arkmesh::sim_ode {

// After all robots' turns of tick `number`: the robots' offers go to the medium, each outcome to its robot, the robot's
// reply to the medium. `heard` becomes what robots receive in this tick. Throws ProgramFault.
void exchange_infrared(std::int64_t number, const ContactWorld& world, RobotHost& host, InfraredMedium& medium,
                       std::vector<Reception>& heard);

}  // namespace arkmesh::sim_ode
