/* Waits by reading the clock; green for a second, dark for a second. Writes the clock, too. */
#include <kilolib.h>

static void wait_ticks(uint32_t n) {
  uint32_t end = kilo_ticks + n;
  while (kilo_ticks < end);
}
void setup() { kilo_ticks = 1000; }
void loop() {
  set_color(RGB(0, 1, 0));
  wait_ticks(30);
  set_color(RGB(0, 0, 0));
  wait_ticks(30);
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
