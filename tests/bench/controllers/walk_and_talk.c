/* Turns and drives at random, each 0.5 to 1 s anew; always has a message to send; keeps what it hears. */
#include <stdlib.h>

#include <kilolib.h>

static message_t out;
static uint8_t heard, nearest;
static uint32_t next;

message_t *tx() { return &out; }
void rx(message_t *m, distance_measurement_t *d) {
  const uint8_t mm = estimate_distance(d);
  heard = m->data[0];
  if (mm < nearest) nearest = mm;
}
void setup() {
  srand(rand_hard());
  out.type = NORMAL;
  out.data[0] = kilo_uid;
  out.crc = message_crc(&out);
}
void loop() {
  if (kilo_ticks < next) return;
  next = kilo_ticks + 15 + rand() % 16;
  spinup_motors();
  switch (rand() & 3) {
    case 0: set_motors(kilo_turn_left, 0); break;
    case 1: set_motors(0, kilo_turn_right); break;
    default: set_motors(kilo_straight_left, kilo_straight_right);
  }
}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_message_tx = tx;
  kilo_start(setup, loop);
}
