/* Robot 0 drives straight ahead for ever, the others stand. */
#include <kilolib.h>

void setup() {
  if (kilo_uid == 0) set_motors(kilo_straight_left, kilo_straight_right);
}
void loop() {}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
