/* The C library's own, and how far a robot's double reaches (robot_types.cpp). */
#include_next <float.h>
#ifndef ARKMESH_PC_TYPES
#undef DBL_MAX
#undef DBL_MIN
#undef DBL_EPSILON
#undef DBL_DIG
#define DBL_MAX FLT_MAX
#define DBL_MIN FLT_MIN
#define DBL_EPSILON FLT_EPSILON
#define DBL_DIG FLT_DIG
#endif
