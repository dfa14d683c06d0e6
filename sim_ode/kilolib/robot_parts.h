/* What the files of the robot's side of the library share. */
#ifndef ARKMESH_ROBOT_PARTS_H
#define ARKMESH_ROBOT_PARTS_H

#include "kilolib.h"
#include "robot_abi.h"

/* State of a robot: lies in the section that is exchanged when the turn passes from robot to robot. */
#define ROBOT __attribute__((section(".robot_host")))
#define HIDDEN __attribute__((visibility("hidden")))
/* Stands in for the C library's unless the program has its own. */
#define STAND_IN __attribute__((visibility("hidden"), weak))

#undef kilo_ticks
#undef printf

/* The simulator. */
extern HIDDEN struct arkmesh_host arkmesh_calls;

/* A robot does about this much in a tick; about 0.65 microseconds each. */
enum { work_per_tick = 50000 };
extern HIDDEN uint32_t arkmesh_work;
HIDDEN void arkmesh_give_time(const void* from);

/* The call itself, before the address to return to. */
#define CALLER ((const char*)__builtin_return_address(0) - 1)
/* What a call of the library takes: so a loop that waits for something and calls the library meanwhile takes time, as
 * on the robot. */
#define SPEND(amount)                                                           \
  do {                                                                          \
    if ((arkmesh_work += (amount)) >= work_per_tick) arkmesh_give_time(CALLER); \
  } while (0)

#endif
