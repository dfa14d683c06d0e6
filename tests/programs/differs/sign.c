/* Takes a char for a signed number: on a robot, and here, it has no sign, so this never turns. */
#include <kilolib.h>
char turn = -1;
void setup() {}
void loop() {
  if (turn < 0)
    set_motors(kilo_turn_left, 0);
  else
    set_motors(0, kilo_turn_right);
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
