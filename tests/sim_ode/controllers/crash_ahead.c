/* All drive ahead, in waits; robot 2 writes through a null pointer after two seconds. */
#include <kilolib.h>

static uint8_t *nowhere;
void setup() {
  spinup_motors();
  set_motors(kilo_straight_left, kilo_straight_right);
}
void loop() {
  if (kilo_ticks > 61 && kilo_uid == 2)
    *nowhere = 1;
  delay(100);
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
