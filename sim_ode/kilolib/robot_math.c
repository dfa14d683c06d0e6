/* Mathematics under the C library's names, unless the program has its own: the simulator's, because the C library's
   depend on the CPU. What is missing here is exact anyway (sqrt, fmod, floor, ...), or a robot's library lacks it. */
#include "robot_parts.h"

#define OF_ONE(name)                                                                       \
  extern __attribute__((visibility("default"), weak)) double arkmesh_fixed_##name(double); \
  STAND_IN double name(double x) {                                                         \
    return arkmesh_fixed_##name(x);                                                        \
  }                                                                                        \
  STAND_IN float name##f(float x) {                                                        \
    return (float)arkmesh_fixed_##name(x);                                                 \
  }
#define OF_TWO(name)                                                                               \
  extern __attribute__((visibility("default"), weak)) double arkmesh_fixed_##name(double, double); \
  STAND_IN double name(double x, double y) {                                                       \
    return arkmesh_fixed_##name(x, y);                                                             \
  }                                                                                                \
  STAND_IN float name##f(float x, float y) {                                                       \
    return (float)arkmesh_fixed_##name(x, y);                                                      \
  }

OF_ONE(sin)
OF_ONE(cos)
OF_ONE(tan)
OF_ONE(asin)
OF_ONE(acos)
OF_ONE(atan)
OF_ONE(sinh)
OF_ONE(cosh)
OF_ONE(tanh)
OF_ONE(exp)
OF_ONE(exp2)
OF_ONE(log)
OF_ONE(log2)
OF_ONE(log10)
OF_ONE(cbrt)
OF_TWO(atan2)
OF_TWO(pow)
OF_TWO(hypot)

/* What the compiler makes of a sine and a cosine of the same angle. */
STAND_IN void sincos(double x, double* sine, double* cosine) {
  *sine = arkmesh_fixed_sin(x);
  *cosine = arkmesh_fixed_cos(x);
}
STAND_IN void sincosf(float x, float* sine, float* cosine) {
  *sine = (float)arkmesh_fixed_sin(x);
  *cosine = (float)arkmesh_fixed_cos(x);
}
