/* Clocks that agree by assignment: whoever hears a later clock takes it as its own kilo_ticks. Flashes white when the common
   clock is a multiple of 96 ticks. */
#include <kilolib.h>

message_t m;
volatile uint32_t later = 0;

void setup() {
    kilo_ticks = (uint32_t)rand_hard() << 4;
    m.type = NORMAL;
}

void loop() {
    uint32_t heard = later;
    if (heard > kilo_ticks) kilo_ticks = heard;
    if (kilo_ticks % 96 < 10) set_color(RGB(3, 3, 3));
    else set_color(RGB(0, 0, 0));
}

message_t *tx() {
    uint32_t now = kilo_ticks;
    m.data[0] = now;
    m.data[1] = now >> 8;
    m.data[2] = now >> 16;
    m.data[3] = now >> 24;
    m.crc = message_crc(&m);
    return &m;
}

void rx(message_t *in, distance_measurement_t *d) {
    uint32_t t = (uint32_t)in->data[3] << 24 | (uint32_t)in->data[2] << 16 | (uint16_t)in->data[1] << 8 | in->data[0];
    if (t > later) later = t;
}

int main() {
    kilo_init();
    kilo_message_tx = tx;
    kilo_message_rx = rx;
    kilo_start(setup, loop);
    return 0;
}
