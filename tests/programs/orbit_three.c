/* Orbit round robot 0 with hysteresis and smoothing of distances over the last four messages; loses the star, stops, finds it again. */
#include <kilolib.h>
#include <string.h>
enum motion { HALT, LEFT, RIGHT, AHEAD };
static const uint8_t near_mm = 50, far_mm = 62;
static uint8_t window[4], filled, at;
static uint32_t last_heard;
static enum motion now = HALT;
static message_t star;
static volatile uint8_t fresh;
static void go(enum motion m) {
    if (m == now) return;
    if (m != HALT) spinup_motors();
    now = m;
    switch (m) {
    case HALT: set_motors(0, 0); break;
    case LEFT: set_motors(kilo_turn_left, 0); break;
    case RIGHT: set_motors(0, kilo_turn_right); break;
    case AHEAD: set_motors(kilo_straight_left, kilo_straight_right);
    }
}
static void heard(message_t *m, distance_measurement_t *d) {
    if (m->type != NORMAL || m->data[0] != 0x51) return;
    window[at++ & 3] = estimate_distance(d);
    if (filled < 4) filled++;
    last_heard = kilo_ticks;
    fresh = 1;
}
static message_t *talk(void) { return kilo_uid == 0 ? &star : NULL; }
static void setup(void) { memset(&star, 0, sizeof star); star.data[0] = 0x51; star.type = NORMAL; star.crc = message_crc(&star); }
static void loop(void) {
    if (kilo_uid == 0) { set_color(RGB(3, 3, 0)); return; }
    if (fresh) {
        unsigned sum = 0;
        for (uint8_t i = 0; i < filled; i++) sum += window[i];
        const uint8_t mean = sum / filled;
        fresh = 0;
        set_color(mean < near_mm ? RGB(0, 3, 0) : mean > far_mm ? RGB(0, 0, 3) : RGB(0, 3, 3));
        go(mean < near_mm ? RIGHT : mean > far_mm ? LEFT : AHEAD);
    }
    if (kilo_ticks - last_heard > 3 * TICKS_PER_SEC) { go(HALT); set_color(RGB(3, 0, 0)); filled = 0; }
}
int main(void) { kilo_init(); kilo_message_rx = heard; kilo_message_tx = talk; kilo_start(setup, loop); return 0; }
