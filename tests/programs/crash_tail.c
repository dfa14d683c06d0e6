/* Divides by zero in a function that the last statement of a callback's last statement calls. */
#include <kilolib.h>
message_t m;
int zero, result;
void inner(int by) {
    result = 100 / by;
}
void middle(int by) { inner(by); }
void rx(message_t *in, distance_measurement_t *d) { middle(zero); }
message_t *tx() { return &m; }
void setup() { m.crc = message_crc(&m); }
void loop() {}
int main() { kilo_init(); kilo_message_rx = rx; kilo_message_tx = tx; kilo_start(setup, loop); return 0; }
