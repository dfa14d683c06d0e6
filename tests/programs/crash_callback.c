/* Calls a null function pointer when it hears something. */
#include <kilolib.h>

void (*handler)(void) = 0;
message_t m;

void rx(message_t *in, distance_measurement_t *d) { handler(); }
message_t *tx() { return &m; }
void setup() {
    m.type = NORMAL;
    m.crc = message_crc(&m);
}
void loop() {}

int main() {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
