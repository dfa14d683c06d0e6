/* Blinks each half second by the clock, which it keeps in an int: until the clock no longer fits. */
#include <kilolib.h>

static int changed, green;
static void setup(void) {}
static void loop(void) {
  if (kilo_ticks > changed + 16) {
    changed = kilo_ticks;
    green = !green;
    set_color(green ? RGB(0, 1, 0) : RGB(1, 0, 0));
  }
}
int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
