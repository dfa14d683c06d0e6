/* Shows how the measured distance to a neighbour compares with what a broadcast of type 2 said (data[0], mm). */
#include <kilolib.h>

static message_t out;
static uint8_t expected;
message_t *tx() { return &out; }
void rx(message_t *m, distance_measurement_t *d) {
  const int mm = estimate_distance(d);
  if (m->type == 2) expected = m->data[0];
  if (m->type == 3) set_color(mm >= expected - 1 && mm <= expected + 1 ? RGB(0, 1, 0) : RGB(1, 0, 0));
}
void setup() {
  out.type = 3;
  out.crc = message_crc(&out);
}
void loop() {}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_message_tx = tx;
  kilo_start(setup, loop);
}
