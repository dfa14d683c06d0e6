/* Waits in the receive callback for a second message, which cannot come there. */
#include <kilolib.h>
volatile int count = 0;
message_t m;
void rx(message_t *in, distance_measurement_t *d) {
    int before = ++count;
    while (count == before) ;
}
message_t *tx() { return &m; }
void setup() { m.crc = message_crc(&m); }
void loop() { }
int main() { kilo_init(); kilo_message_rx = rx; kilo_message_tx = tx; kilo_start(setup, loop); return 0; }
