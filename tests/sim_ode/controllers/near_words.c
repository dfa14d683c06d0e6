/* Shows blue once it was told a word from overhead. Ignores what comes from farther than 100 mm, as from robots. */
#include <kilolib.h>

static uint8_t told;
void rx(message_t *m, distance_measurement_t *d) {
  if (estimate_distance(d) <= 100 && m->type == 0) told = 1;
}
void setup() {}
void loop() { set_color(told ? RGB(0, 0, 1) : RGB(1, 0, 0)); }
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_start(setup, loop);
}
