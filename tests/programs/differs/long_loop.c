/* Computes for longer than a tick in one call of loop, where a simulated robot takes no time. */
#include <kilolib.h>
#include <math.h>
float sum;
void setup() {}
void loop() {
  uint16_t i;
  sum = 0;
  for (i = 1; i < 800; i++) sum += sqrt(i) / i;
  set_color(sum > 10 ? RGB(0, 1, 0) : RGB(1, 0, 0));
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
