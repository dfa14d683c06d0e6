/* Takes an index from a message that is beyond the array. */
#include <kilolib.h>
uint8_t colours[4] = {1, 2, 3, 4}, after[30];
message_t out;
uint8_t heard;
message_t *send() { return &out; }
void hear(message_t *m, distance_measurement_t *d) {
  heard = m->data[0];
  set_color(colours[heard]);
}
void setup() {
  after[kilo_uid % 30] = 9;
  out.data[0] = 4 + kilo_uid;
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
