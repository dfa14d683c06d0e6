/* The same with short delays; includes another program. */
#define ROUND_MS 100
#include "rounds.c"
