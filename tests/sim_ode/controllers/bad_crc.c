/* Even robots forget the checksum. Who hears an even robot shows red, an odd one green. */
#include <kilolib.h>

static message_t out;
message_t *tx() { return &out; }
void rx(message_t *m, distance_measurement_t *d) { set_color(m->data[0] % 2 ? RGB(0, 1, 0) : RGB(1, 0, 0)); }
void setup() {
  out.data[0] = kilo_uid;
  if (kilo_uid % 2) out.crc = message_crc(&out);
}
void loop() {}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_message_tx = tx;
  kilo_start(setup, loop);
}
