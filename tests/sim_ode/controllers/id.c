/* Shows green after 5000 calls of loop where its id is 10001 or 384, red where it has another one. */
#include "kilolib.h"

static uint32_t calls;

static void setup(void) {}
static void loop(void) {
  if (++calls > 5000) set_color(kilo_uid == 10001 || kilo_uid == 384 ? RGB(0, 1, 0) : RGB(1, 0, 0));
}
int main(void) {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
