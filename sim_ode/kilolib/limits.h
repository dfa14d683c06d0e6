/* The C library's own, and how far a robot's types reach (robot_types.cpp). */
#include_next <limits.h>
#ifndef ARKMESH_PC_TYPES
#undef INT_MAX
#undef INT_MIN
#undef UINT_MAX
#undef LONG_MAX
#undef LONG_MIN
#undef ULONG_MAX
#define INT_MAX 32767
#define INT_MIN (-32767 - 1)
#define UINT_MAX 65535
#define LONG_MAX 2147483647
#define LONG_MIN (-2147483647 - 1)
#define ULONG_MAX 4294967295U
#endif
