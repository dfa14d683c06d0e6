/* Mathematics under the C library's names, unless the program has its own: the simulator's, because the C library's
   depend on the CPU. What is missing here is exact anyway (sqrt, fmod, floor, ...), or a robot's library lacks it. */
#include "robot_parts.h"

#define OF_ONE(name)                     \
  STAND_IN double name(double x) {       \
    return arkmesh_calls.name(x);        \
  }                                      \
  STAND_IN float name##f(float x) {      \
    return (float)arkmesh_calls.name(x); \
  }
#define OF_TWO(name)                         \
  STAND_IN double name(double x, double y) { \
    return arkmesh_calls.name(x, y);         \
  }                                          \
  STAND_IN float name##f(float x, float y) { \
    return (float)arkmesh_calls.name(x, y);  \
  }
ARKMESH_MATHEMATICS(OF_ONE, OF_TWO)

/* What the compiler makes of a sine and a cosine of the same angle. */
STAND_IN void sincos(double x, double* sine, double* cosine) {
  *sine = arkmesh_calls.sin(x);
  *cosine = arkmesh_calls.cos(x);
}
STAND_IN void sincosf(float x, float* sine, float* cosine) {
  *sine = (float)arkmesh_calls.sin(x);
  *cosine = (float)arkmesh_calls.cos(x);
}
