/* Divides by zero in a callback. */
#include <kilolib.h>

volatile int zero;
void rx(message_t *m, distance_measurement_t *d) { set_color(100 / zero); }
void setup() {}
void loop() {}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_start(setup, loop);
}
