/* Robot 1 writes past its block after a second, and goes on doing so; each robot shows red when its block is not as it
   was written. */
#include "kilolib.h"
#include <stdlib.h>

static volatile uint8_t* mine;

static void setup(void) {
  mine = malloc(24); /* line 9 */
  for (uint8_t i = 0; i < 24; i++) mine[i] = 7;
  set_color(RGB(0, 1, 0));
}
static void loop(void) {
  if (kilo_uid == 1 && kilo_ticks > 30)
    for (uint16_t i = 24; i < 600; i++) mine[i] = 99;
  for (uint8_t i = 0; i < 24; i++)
    if (mine[i] != 7) set_color(RGB(1, 0, 0));
  if (kilo_uid == 1 && kilo_ticks > 60 && mine[500] == 99) set_color(RGB(0, 0, 1)); /* it has what it wrote */
}
int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
