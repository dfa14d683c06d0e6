/* Red after setup, blue once loop has run for two seconds; motors on in each loop. */
#include <assert.h>
#include <kilolib.h>

static uint8_t setups;
static uint16_t loops;
void setup() {
  setups++;
  assert(setups == 1);
  set_color(RGB(1, 0, 0));
}
void loop() {
  set_motors(kilo_straight_left, kilo_straight_right);
  if (++loops >= 61) set_color(RGB(0, 0, 1));
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
}
