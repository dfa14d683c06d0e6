/* Drives and turns at random; sends all the time. Even robots use delay(), odd ones the clock. */
#include <stdlib.h>

#include <kilolib.h>

static message_t message;
static uint32_t next;

message_t *tx() { return &message; }
void rx(message_t *m, distance_measurement_t *d) {
  set_color(RGB(m->data[0] & 1, estimate_distance(d) < 60, m->data[0] >> 1 & 1));
}
static void draw(void) {
  const int what = rand() % 3;
  spinup_motors();
  if (what == 0) set_motors(kilo_straight_left, kilo_straight_right);
  if (what == 1) set_motors(kilo_turn_left, 0);
  if (what == 2) set_motors(0, kilo_turn_right);
}
void setup() {
  srand(rand_hard());
  message.type = NORMAL;
  message.data[0] = kilo_uid;
  message.crc = message_crc(&message);
}
void loop() {
  if (kilo_uid % 2 == 0) {
    draw();
    delay(700 + rand() % 500);
  } else if (kilo_ticks >= next) {
    next = kilo_ticks + 16 + rand() % 16;
    draw();
  }
}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_message_tx = tx;
  kilo_start(setup, loop);
}
