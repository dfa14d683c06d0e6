/* Style: keeps times in 16 bits and compares differences, also across the wrap; a message counter of one byte that wraps. Blinks
   with a period of 62 ticks. */
#include <kilolib.h>

uint16_t last;
uint8_t on = 0, serial = 0;
message_t m;

void setup() {
    kilo_ticks = 65500;
    last = kilo_ticks;
    m.type = NORMAL;
}

void loop() {
    uint16_t now = kilo_ticks;
    if ((uint16_t)(now - last) >= 31) {
        last = now;
        on = !on;
        set_color(on ? RGB(0, 2, 2) : RGB(0, 0, 0));
    }
}

message_t *tx() {
    m.data[0] = serial++;
    m.crc = message_crc(&m);
    return &m;
}

int main() {
    kilo_init();
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
