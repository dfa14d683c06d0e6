/* Style: waits inside loop() for a message with a plain global flag, showing in the waiting loop that it waits. Green after each. */
#include <kilolib.h>
int got_message = 0;
message_t m;
void message_rx(message_t *in, distance_measurement_t *d) { got_message = 1; }
message_t *message_tx() { return &m; }
void setup() { m.type = NORMAL; m.crc = message_crc(&m); }
void loop() {
    while (1) {
        while (got_message == 0) {
            set_color(RGB(1, 0, 0));
            set_motors(0, 0);
        }
        got_message = 0;
        set_color(RGB(0, 3, 0));
        delay(100);
    }
}
int main() { kilo_init(); kilo_message_rx = message_rx; kilo_message_tx = message_tx; kilo_start(setup, loop); return 0; }
