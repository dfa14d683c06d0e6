// The mathematics of robots' programs: theirs is hal/fixed_math, so that a program does the same whatever the CPU.
// Their side is kilolib/robot_math.c.
#pragma once

namespace arkmesh::sim_ode {

// False when this process was linked so that robots' programs cannot find it.
bool has_robot_math();

}  // namespace arkmesh::sim_ode
