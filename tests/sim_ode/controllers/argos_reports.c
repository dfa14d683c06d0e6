/* Says how it sends: red while a message waits, green once it has gone; then not again, if it was asked for only one.
   Messages that arrive count in data[1] of what it sends. Message 3 sets kilo_tx_period, in hundreds. */
#include <kilolib.h>

static message_t out;
static uint8_t heard;
message_t *tx() {
  out.data[0] = kilo_uid;
  out.data[1] = heard;
  set_color(RGB(3, 0, 0));
  return &out;
}
void gone() { set_color(RGB(0, 3, 0)); }
void rx(message_t *message, distance_measurement_t *distance) {
  (void)distance;
  ++heard;
  if (message->type == 3) kilo_tx_period = 100 * message->data[0];
}
void setup() {}
void loop() {}
int main() {
  kilo_init();
  kilo_message_tx = tx;
  kilo_message_tx_success = gone;
  kilo_message_rx = rx;
  kilo_start(setup, loop);
}
