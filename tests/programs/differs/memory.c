/* Variables, heap and stack are more than a robot has. */
#include <kilolib.h>
#include <stdlib.h>
#include <string.h>
uint8_t history[900];
uint8_t *more;
uint8_t depth;
uint16_t deep(uint8_t n) {
  volatile uint8_t room[40];
  memset((void *)room, n, sizeof room);
  return n == 0 ? room[3] : deep(n - 1) + room[n];
}
void setup() { more = malloc(700); }
void loop() {
  history[kilo_ticks % 900] = kilo_ticks;
  if (depth < 12 && kilo_ticks % 31 == 0) depth++;
  if (deep(depth) == 12345) set_color(RGB(1, 1, 1));
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
