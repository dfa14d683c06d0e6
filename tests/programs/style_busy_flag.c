/* Style: waits in loop, with delay(1), for a flag that only the receive callback sets; says a word itself when the flag came. */
#include <kilolib.h>

volatile uint8_t flag = 0;
message_t word;

void rx(message_t *m, distance_measurement_t *d) { flag = 1; }
message_t *tx() { return &word; }

void setup() {
    word.type = NORMAL;
    word.crc = message_crc(&word);
}

void loop() {
    set_color(RGB(3, 0, 0));
    while (!flag) delay(1);
    flag = 0;
    set_color(RGB(0, 3, 0));
    delay(700);
}

int main() {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
