/* The optional buffers and the serial line's header. Robot 0 sends four numbered messages, the others expect them. */
#define DEBUG
#include <stdio.h>
#include "debug.h"
#include "kilolib.h"
#include "message_buffered.h"

static uint8_t next;
void setup() {
  uint8_t i;
  message_t m = {{0}};
  debug_init();
  printf("robot %d\n", kilo_uid);
  kilo_message_buffered();
  if (kilo_uid) return;
  for (i = 0; i < 4; i++) {
    m.type = 7;
    m.data[0] = i;
    m.crc = message_crc(&m);
    txbuffer_push(&m);
  }
}
void loop() {
  distance_measurement_t d;
  message_t *m = rxbuffer_peek(&d);
  if (!m) return;
  if (m->type == 7 && m->data[0] == next) next++;
  rxbuffer_pop();
  if (next == 4 && rxbuffer_size() == 0) set_color(RGB(0, 1, 0));
}
int main() {
  kilo_init();
  kilo_start(setup, loop);
  return 0;
}
