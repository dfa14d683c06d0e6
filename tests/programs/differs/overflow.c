/* Computes with a reading of light in an int: on a robot the product overflows 16 bits. */
#include <kilolib.h>
int average, percent;
void setup() { percent = 300; }
void loop() {
  average = get_ambientlight() * percent / 100;
  if (average > 200)
    set_motors(kilo_turn_left, 0);
  else
    set_motors(0, 0);
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
