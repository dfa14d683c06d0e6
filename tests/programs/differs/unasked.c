/* Takes an index from a message that is within the array as long as only robots of this program speak. */
#include <kilolib.h>
uint8_t colours[4] = {1, 2, 3, 4}, after[30];
message_t out;
message_t *send() { return &out; }
void hear(message_t *m, distance_measurement_t *d) {
  set_color(colours[m->data[0]]);
}
void setup() {
  after[kilo_uid % 30] = 9;
  out.data[0] = kilo_uid % 4;
  out.crc = message_crc(&out);
}
void loop() {}
int main() {
  kilo_init();
  kilo_message_rx = hear;
  kilo_message_tx = send;
  kilo_start(setup, loop);
  return 0;
}
