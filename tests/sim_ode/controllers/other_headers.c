/* As programs are that only other simulators compiled: what stdio.h and stdlib.h have comes from those simulators'
   headers, and so do debug fields. malloc() without a declaration works on a robot, too. */
#include "kilolib.h"
#include <debug.h>
#ifdef OF_KILOMBO
#include <kilombo.h>
FILE* file;
#elif defined(OF_ARGOS)
static uint16_t most = RAND_MAX;
#endif

static uint8_t* mine;
static void setup(void) {
  mine = malloc(1);
  *mine = 2;
  debug_info_create();
}
static void loop(void) {
  debug_info_set(gradient, *mine);
  debug_print("own %d\n", *mine);
  set_color(RGB(0, *mine, 0));
}
int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
