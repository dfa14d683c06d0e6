/* News that spread from robot 0, blue: with the checksum of a message that was empty still, as ARGoS lets through. */
#include <kilolib.h>

static message_t out;
static uint8_t knows;
message_t *tx() { return knows ? &out : 0; }
void rx(message_t *m, distance_measurement_t *d) {
  (void)d;
  if (m->type == 7) knows = 1;
}
void setup() {
  out.crc = message_crc(&out);
  out.type = 7;
  knows = kilo_uid == 0;
}
void loop() { set_color(knows ? RGB(0, 0, 1) : RGB(1, 0, 0)); }
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_message_tx = tx;
  kilo_start(setup, loop);
}
