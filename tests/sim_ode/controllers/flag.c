/* One-slot flags: the receiver remembers the last message only, and its loop must see each one. Robot 0 sends numbers. */
#include <assert.h>
#include <kilolib.h>

static message_t out;
static uint8_t have_new, number;
static uint8_t expected;

message_t *tx() { return kilo_uid == 0 ? &out : 0; }
void sent() {
  out.data[0]++;
  out.crc = message_crc(&out);
}
void rx(message_t *m, distance_measurement_t *d) {
  if (m->type != 5) return;
  assert(!have_new); /* the one before was seen */
  have_new = 1;
  number = m->data[0];
}
void setup() {
  out.type = 5;
  out.crc = message_crc(&out);
}
void loop() {
  if (!have_new) return;
  have_new = 0;
  assert(number == expected);
  expected = number + 1;
  if (expected == 60) set_color(RGB(0, 1, 0));
}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_message_tx = tx;
  kilo_message_tx_success = sent;
  kilo_start(setup, loop);
}
