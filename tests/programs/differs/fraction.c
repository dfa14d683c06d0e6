/* A power of a whole number is whole on a PC; in a robot's float it may be a little less. */
#include <kilolib.h>
#include <math.h>
uint16_t level, step;
void setup() {}
void loop() {
  step = step % 40 + 1;
  level = pow(step, 3);
  if (kilo_ticks > 300) set_color(level & 63);
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
