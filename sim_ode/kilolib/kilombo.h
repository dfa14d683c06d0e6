/* For programs that can also be built for another simulator: what they get of its header on a robot. */
#ifndef ARKMESH_KILOMBO_H
#define ARKMESH_KILOMBO_H
#include "kilolib.h"
#define REGISTER_USERDATA(type)  \
  static type arkmesh_user_data; \
  type* mydata = &arkmesh_user_data;
#define SET_CALLBACK(name, function)
#endif
