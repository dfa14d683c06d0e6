/* Art: a fade of many delays inside the receive callback and in setup, and a pulse of nested loops in loop(). */
#include <kilolib.h>
message_t note;
int pulses;
void flash(int r, int g, int b, int ms) { set_color(RGB(r, g, b)); delay(ms); }
void rx(message_t *m, distance_measurement_t *d) {
    int i;
    for (i = 0; i < 4; i++) flash(i, 0, 3 - i, 50);
}
message_t *tx() { return pulses > 0 ? &note : 0; }
void sent() { pulses--; }
void setup() {
    int i;
    for (i = 0; i < 8; i++) { flash(i & 3, i >> 1, 3, 120); flash(0, 0, 0, 120); }
    note.type = 42; note.crc = message_crc(&note);
}
void loop() {
    int a, b;
    for (a = 0; a < 3; a++) {
        for (b = 0; b < 4; b++) flash(b, a, 0, 80);
        for (b = 3; b >= 0; b--) flash(b, a, 0, 80);
    }
    pulses += 1 + (rand_hard() & 1);
    delay(rand_hard() * 4);
}
int main() { kilo_init(); kilo_message_rx = rx; kilo_message_tx = tx; kilo_message_tx_success = sent; kilo_start(setup, loop); return 0; }
