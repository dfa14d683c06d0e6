/* rand_seed before any draw: the counter starts at 0. */
#include <assert.h>
#include <kilolib.h>

void setup() {
  static const uint8_t soft[] = {9, 67, 89, 149, 61, 210, 65, 74};
  uint8_t i;
  rand_seed(1);
  for (i = 0; i < 8; i++) assert(rand_soft() == soft[i]);
  set_color(RGB(0, 1, 0));
}
void loop() {}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
