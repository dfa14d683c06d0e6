/* For programs that can also be built for another simulator: what they get of its header on a robot, and its callbacks,
   which may be set and are never called: they serve its display. */
#ifndef ARKMESH_KILOMBO_H
#define ARKMESH_KILOMBO_H
#include <stdio.h>
#include <stdlib.h>

#include "kilolib.h"
#define REGISTER_USERDATA(type)  \
  static type arkmesh_user_data; \
  type* mydata = &arkmesh_user_data;
#define SET_CALLBACK(name, function)
#define ARKMESH_CALLBACK(result, name, ...) \
  __attribute__((visibility("hidden"), weak)) result (*callback_##name)(__VA_ARGS__) = 0;
ARKMESH_CALLBACK(char*, botinfo, void)
ARKMESH_CALLBACK(void*, json_state, void)
ARKMESH_CALLBACK(void, global_setup, void)
ARKMESH_CALLBACK(void, F5, void)
ARKMESH_CALLBACK(void, F6, void)
#endif
