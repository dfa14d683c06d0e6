/* Synchronisation by phase jumps: a robot that hears a flash moves its own clock on by a share of its phase, in floating point. */
#include <kilolib.h>
#include <math.h>
#include <stdlib.h>
#define PERIOD 64.0f
#define EPSILON 0.05
static float phase;
static uint32_t last;
static volatile uint8_t flashes_heard = 0;
static message_t flash;
static uint8_t fire = 0, sent = 0;
static uint32_t dark_at;

message_t *tx(void) { return fire ? &flash : (message_t *)0; }
void tx_ok(void) { fire = 0; sent = 1; }
void rx(message_t *m, distance_measurement_t *d) { if (m->type == 7) flashes_heard++; }

float normalised(float x) { return fmodf(x, PERIOD); }

void setup(void) {
    srand(kilo_uid + 1);
    rand_seed(rand_hard());
    phase = (float)rand() / RAND_MAX * PERIOD;
    flash.type = 7;
    flash.crc = message_crc(&flash);
    last = kilo_ticks;
}

void loop(void) {
    if (flashes_heard) {
        flashes_heard = 0;
        phase += EPSILON * PERIOD * sinf(M_PI * phase / PERIOD);
    }
    if (kilo_ticks != last) {
        phase += (float)(kilo_ticks - last);
        last = kilo_ticks;
        if (phase >= PERIOD) {
            phase = normalised(phase);
            fire = 1;
            set_color(RGB(3,3,3));
            dark_at = last + 8;
        }
        if (last >= dark_at) set_color(RGB(0,0,0));
    }
}

int main(void) {
    kilo_init();
    kilo_message_tx = tx;
    kilo_message_tx_success = tx_ok;
    kilo_message_rx = rx;
    kilo_start(setup, loop);
    return 0;
}
