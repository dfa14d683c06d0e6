/* Shows by its colour which macros it was built with, hears its neighbours, and tells its lab when it has. */
#include <kilolib.h>
#include <arkmesh_say.h>

#ifndef ROLE
#define ROLE 1
#endif

static message_t out;
message_t *tx() { return &out; }
static uint8_t heard;
void rx(message_t *message, distance_measurement_t *distance) {
  (void)distance;
  if (message->data[1] == ROLE || heard) return;
  heard = 1;
  arkmesh_say(ROLE, 1000 * message->data[1] + message->data[0]);
}
void setup() {
  out.data[0] = kilo_uid;
  out.data[1] = ROLE;
  out.crc = message_crc(&out);
  set_color(1 << 2 * (ROLE - 1)); /* red, green, blue */
}
void loop() {}
int main() {
  kilo_init();
  kilo_message_tx = tx;
  kilo_message_rx = rx;
  kilo_start(setup, loop);
}
