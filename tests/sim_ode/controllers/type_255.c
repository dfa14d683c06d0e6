/* Says messages of type 255, which belongs to the robots' library; who hears one shows red. */
#include <kilolib.h>

static message_t out;
message_t *tx() { return &out; }
void rx(message_t *m, distance_measurement_t *d) { set_color(RGB(1, 0, 0)); }
void setup() {
  out.type = 255;
  out.crc = message_crc(&out);
}
void loop() {}
int main() {
  kilo_init();
  kilo_message_rx = rx;
  kilo_message_tx = tx;
  kilo_start(setup, loop);
}
