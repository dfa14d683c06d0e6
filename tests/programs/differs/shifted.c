/* Puts an id together from two bytes: on a robot an int has no room for it, and its sign spreads. */
#include <kilolib.h>
message_t out;
uint32_t last_id;
message_t *send() { return &out; }
void hear(message_t *m, distance_measurement_t *d) {
  last_id = m->data[0] << 8 | m->data[1];
  if (last_id > 70000) set_color(RGB(3, 0, 0));
}
void setup() {
  out.type = NORMAL;
  out.data[0] = 0x90;
  out.data[1] = kilo_uid;
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
