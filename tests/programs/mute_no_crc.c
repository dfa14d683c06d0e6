/* Forgets the checksum: other simulators deliver its messages, robots never hear them. Green when something was heard, red when not. */
#include <kilolib.h>

message_t m;
uint8_t heard = 0;

void rx(message_t *in, distance_measurement_t *d) { heard = 1; }
message_t *tx() { return &m; }

void setup() {
    m.type = NORMAL;
    m.data[0] = 7;
}

void loop() { set_color(heard ? RGB(0, 3, 0) : RGB(3, 0, 0)); }

int main() {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
