/* Sends what it never wrote: malloc gives memory as it was. */
#include <kilolib.h>
#include <stdlib.h>
message_t *out;
message_t *give() { return out; }
void setup() {
  out = malloc(sizeof *out);
  out->type = NORMAL;
  out->data[0] = kilo_uid;
  out->crc = message_crc(out);
}
void loop() {}
int main() {
  kilo_init();
  kilo_message_tx = give;
  kilo_start(setup, loop);
  return 0;
}
