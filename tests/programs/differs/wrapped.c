/* Subtracts clocks of 16 bits: on a robot the difference is never negative. */
#include <kilolib.h>
uint16_t mine = 1000, theirs = 900;
int32_t late;
void setup() { }
void loop() {
  late = theirs - mine;
  set_color(late < 0 ? RGB(3, 0, 0) : RGB(0, 3, 0));
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
