/* Style: a callback that copies and sets a flag, all work in loop; green when no message was overwritten before loop saw it. */
#include <kilolib.h>

message_t rcvd;
distance_measurement_t dist;
uint8_t new_message = 0, lost = 0;
uint32_t seen = 0;
message_t m;

void rx(message_t *in, distance_measurement_t *d) {
    if (new_message) lost = 1;
    rcvd = *in;
    dist = *d;
    new_message = 1;
}
message_t *tx() { return &m; }

void setup() {
    m.type = NORMAL;
    m.crc = message_crc(&m);
}

void loop() {
    if (new_message) {
        new_message = 0;
        seen++;
    }
    if (lost) set_color(RGB(3, 0, 0));
    else if (seen > 5) set_color(RGB(0, 3, 0));
}

int main() {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
