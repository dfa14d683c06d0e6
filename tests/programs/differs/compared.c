/* Looks whether a reading is -1, in an unsigned number: on a robot that is 65535 and equal, here it never is. */
#include <kilolib.h>
uint8_t again;
uint16_t light() {
  uint16_t reading = kilo_ticks % 8 == 0 ? -1 : 400;
  again = reading == -1;
  return reading;
}
void setup() {}
void loop() {
  light();
  set_color(again ? RGB(3, 0, 0) : RGB(0, 3, 0));
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
