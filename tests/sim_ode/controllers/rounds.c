/* Counts rounds of two delays; a broadcast of type 2 checks the count (data[0..1], +-1). */
#include <assert.h>
#include <kilolib.h>

#ifndef ROUND_MS
#define ROUND_MS 500
#endif

static uint16_t rounds, wait_ms = ROUND_MS;

void rx(message_t *m, distance_measurement_t *d) {
  if (m->type == 2) {
    const uint16_t expected = m->data[0] | m->data[1] << 8;
    assert(rounds + 1 >= expected && rounds <= expected + 1);
    set_color(RGB(0, 0, 1));
  }
}
void setup() {}
void loop() {
  delay(wait_ms);
  delay(wait_ms);
  rounds++;
}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_start(setup, loop);
}
