/* All drive straight ahead for ever. */
#include <kilolib.h>

void setup() { set_motors(kilo_straight_left, kilo_straight_right); }
void loop() {}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
