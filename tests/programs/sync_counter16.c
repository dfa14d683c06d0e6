/* Synchronisation with a 16-bit counter that all robots pull towards the largest; wraps by modular comparison. */
#include <kilolib.h>
uint16_t counter = 0;
uint32_t last_tick;
message_t m;
uint8_t dirty = 1;
void rx(message_t *in, distance_measurement_t *d) {
    uint16_t other = in->data[0] | (in->data[1] << 8);
    if ((int16_t)(other - counter) > 0) counter = other;
}
message_t *tx() {
    m.type = NORMAL;
    m.data[0] = counter & 0xFF;
    m.data[1] = counter >> 8;
    m.crc = message_crc(&m);
    return &m;
}
void setup() { last_tick = kilo_ticks; counter = 65500u + (kilo_uid & 7); }
void loop() {
    if (kilo_ticks > last_tick) { counter += kilo_ticks - last_tick; last_tick = kilo_ticks; }
    set_color(counter & 32 ? RGB(0, 0, 3) : RGB(0, 3, 0));
}
int main() { kilo_init(); kilo_message_rx = rx; kilo_message_tx = tx; kilo_start(setup, loop); return 0; }
