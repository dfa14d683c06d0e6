/* Prints so much that a simulated robot's tick ends amid it, and answers messages meanwhile: the same on a robot. */
#include <kilolib.h>
#include <stdio.h>
message_t out;
uint8_t colour, calls;
message_t *send() { return &out; }
void setup() { out.crc = message_crc(&out); }
void loop() {
  uint8_t i;
  calls++;
  for (i = 0; i < 120; i++) printf("line %d of call %d\n", i, calls);
  colour = calls & 63;
  set_color(colour);
}
int main() {
  kilo_init();
  kilo_message_tx = send;
  kilo_start(setup, loop);
  return 0;
}
