/* A vote in the manner of published ones, written for ARGoS: opinions in messages of type 255. Blue and red at first;
   a robot takes over what two in a row say; those of ids 0, 4, 8, 12 stay blue. */
#include <kilolib.h>

static message_t out;
static uint8_t opinion, last, row;
message_t *tx() {
  out.data[0] = opinion;
  out.type = 255;
  out.crc = message_crc(&out);
  return &out;
}
void rx(message_t *m, distance_measurement_t *d) {
  (void)d;
  if (m->type != 255) return;
  row = m->data[0] == last ? row + 1 : 1;
  last = m->data[0];
  if (row >= 2 && kilo_uid % 4) opinion = last;
}
void setup() { opinion = kilo_uid % 4 != 1; }
void loop() { set_color(opinion ? RGB(0, 0, 1) : RGB(1, 0, 0)); }
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_message_tx = tx;
  kilo_start(setup, loop);
}
