/* Style: sets kilo_message_tx to 0 and back to be silent for a while; never sets the success callback. Green once it has heard. */
#include <kilolib.h>
message_t msg;
message_t *tx() { return &msg; }
int n = 0;
void rx(message_t *m, distance_measurement_t *d) { n++; }
void setup() { msg.type = NORMAL; msg.crc = message_crc(&msg); kilo_message_tx = 0; }
void loop() {
    if ((kilo_ticks / 100) % 2) kilo_message_tx = tx; else kilo_message_tx = 0;
    if (n > 3) set_color(RGB(0,3,0));
}
int main() { kilo_init(); kilo_message_rx = rx; kilo_start(setup, loop); return 0; }
