/* The C library's own, with the largest random number of the robot's. */
#include_next <stdlib.h>
#undef RAND_MAX
#define RAND_MAX 0x7FFF
