// What a Kilobot is and what an overhead controller can say to it.
#pragma once

#include "hal/arena.hpp"

namespace arkmesh::hal::kilobot {

// 33 mm diameter; Kilobot labs page, ARGoS kilobot_measures.h.
inline constexpr double body_radius_m = 0.0165;

// The largest id that a composite can address; 1023 means nobody.
inline constexpr RobotId max_robot_id = 1022;

// A composite gives each robot 4 bits of kind and 10 bits of value.
inline const RobotModel model{
    .body_radius_m = body_radius_m,
    .max_robot = max_robot_id,
    .kinds = 16,
    .values = 1024,
    .commands = {FleetCommand::Kind::run, FleetCommand::Kind::pause, FleetCommand::Kind::reset,
                 FleetCommand::Kind::sleep, FleetCommand::Kind::voltage, FleetCommand::Kind::charge,
                 FleetCommand::Kind::broadcast}};

}  // namespace arkmesh::hal::kilobot
