/* Style: waits in an empty loop for a volatile flag that only the receive callback sets. Green for half a second per message. */
#include <kilolib.h>

volatile uint8_t heard = 0;
message_t word;

void rx(message_t *m, distance_measurement_t *d) { heard = 1; }
message_t *tx() { return &word; }

void setup() {
    word.type = NORMAL;
    word.crc = message_crc(&word);
}

void loop() {
    set_color(RGB(3, 0, 0));
    while (!heard) ;
    heard = 0;
    set_color(RGB(0, 3, 0));
    delay(500);
}

int main() {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
