/* Sends its number all the time. */
#include <kilolib.h>

static message_t out;
message_t *tx() { return &out; }
void setup() {
  out.data[0] = kilo_uid;
  out.crc = message_crc(&out);
}
void loop() {}
int main() {
  kilo_init();
  kilo_message_tx = tx;
  kilo_start(setup, loop);
}
