/* A word of a simulated robot to its lab: a scenario finds it in `lab.heard`, with the robot's id, in the frame that
   follows. A real Kilobot can say nothing to its overhead controller, so a program for real robots with this header
   does not compile. */
#ifndef ARKMESH_SAY_H
#define ARKMESH_SAY_H

#ifdef __AVR__
#error "arkmesh_say.h is for simulated robots: a real one can say nothing to its lab; let it show its LED"
#endif

#include <stdint.h>

#pragma GCC visibility push(hidden)
void arkmesh_say(uint8_t kind, int32_t value);
#pragma GCC visibility pop

#endif
