/* Each robot from id 300 on writes one value beyond an array on its stack: one, two or four bytes, as far up as its id. */
#include <kilolib.h>

void __attribute__((noinline)) damage(int at) {
  volatile uint8_t room[2] = {1, 2};
  volatile uint8_t* one = room;
  volatile uint16_t* two = (volatile uint16_t*)room;
  volatile uint32_t* four = (volatile uint32_t*)room;
  if (at % 3 == 0) one[at / 3] = at;
  if (at % 3 == 1) two[at / 3] = at;
  if (at % 3 == 2) four[at / 3] = 0;
  set_motors(kilo_straight_left, kilo_straight_right);
}
void setup() {}
void loop() {
  set_motors(kilo_straight_left, kilo_straight_right);
  if (kilo_ticks > 40 && kilo_uid > 299) damage(kilo_uid);
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
