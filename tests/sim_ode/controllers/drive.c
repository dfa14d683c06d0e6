/* Does what a broadcast of type 1 says: data[0] motors (bit 0 first, bit 1 second), without spinning up. */
#include <kilolib.h>

static volatile uint8_t wanted;

void rx(message_t *m, distance_measurement_t *d) {
  (void)d;
  if (m->type == 1) wanted = m->data[0];
}
void setup() {}
void loop() {
  if (wanted == 3) set_motors(kilo_straight_left, kilo_straight_right);
  else set_motors(wanted & 1 ? kilo_turn_left : 0, wanted & 2 ? kilo_turn_right : 0);
}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_start(setup, loop);
}
