/* Green when a message's sender is measured to be farther than it says (data[0], mm), else red. */
#include <kilolib.h>

void rx(message_t *m, distance_measurement_t *d) {
  set_color(estimate_distance(d) > m->data[0] ? RGB(0, 1, 0) : RGB(1, 0, 0));
}
void setup() {}
void loop() {}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_start(setup, loop);
}
