/* Shows the lowest three bits of its id as soon as it runs; a user message with its id in the first byte makes it white, any other dark. */
#include <kilolib.h>

void rx(message_t *m, distance_measurement_t *d) {
  (void)d;
  set_color(m->data[0] == kilo_uid ? RGB(3, 3, 3) : RGB(0, 0, 0));
}
void setup() { set_color(RGB((kilo_uid & 1) * 3, (kilo_uid >> 1 & 1) * 3, (kilo_uid >> 2 & 1) * 3)); }
void loop() {}

int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_start(setup, loop);
  return 0;
}
