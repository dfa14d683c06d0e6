/* Drives straight on for ever. */
#include <kilolib.h>

void setup() {
  spinup_motors();
  set_motors(kilo_straight_left, kilo_straight_right);
}
void loop() {}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
