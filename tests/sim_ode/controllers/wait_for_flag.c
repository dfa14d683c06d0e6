/* Waits in loop, calling nothing, for a flag that its callback sets; green once that has happened five times. */
#include <kilolib.h>
#include <stdio.h>

volatile uint8_t flag;
uint8_t times;
message_t word;

void rx(message_t *m, distance_measurement_t *d) { flag = 1; }
message_t *tx() { return &word; }
void setup() { word.crc = message_crc(&word); }
void loop() {
  while (!flag) continue;
  flag = 0;
  if (++times == 5) set_color(RGB(0, 3, 0));
  putchar('x');
  fprintf(stderr, "y");
}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_message_tx = tx;
  kilo_start(setup, loop);
}
