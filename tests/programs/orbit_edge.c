/* Edge following: robot 1 walks along the edge of the others by keeping its distance to whoever is nearest; all others stand and
   speak. States as an enum, callbacks with empty parentheses. */
#include "kilolib.h"

enum walk { WALK_NONE, WALK_LEFT, WALK_RIGHT, WALK_STRAIGHT };

static enum walk walking = WALK_NONE;
static uint8_t nearest = 255;
static uint32_t window_start = 0;
static message_t beacon;

static void go(enum walk w) {
    if (w == walking) return;
    walking = w;
    switch (w) {
    case WALK_NONE: set_motors(0, 0); break;
    case WALK_LEFT: spinup_motors(); set_motors(kilo_turn_left, 0); break;
    case WALK_RIGHT: spinup_motors(); set_motors(0, kilo_turn_right); break;
    case WALK_STRAIGHT: spinup_motors(); set_motors(kilo_straight_left, kilo_straight_right); break;
    }
}

void setup() {
    beacon.type = NORMAL;
    beacon.data[0] = kilo_uid;
    beacon.crc = message_crc(&beacon);
    set_color(kilo_uid == 1 ? RGB(3, 0, 0) : RGB(0, 0, 1));
}

void loop() {
    if (kilo_uid != 1) return;
    if (kilo_ticks - window_start < 20) return;
    window_start = kilo_ticks;
    if (nearest == 255) go(WALK_STRAIGHT);
    else if (nearest < 45) go(WALK_RIGHT);
    else if (nearest > 55) go(WALK_LEFT);
    else go(WALK_STRAIGHT);
    nearest = 255;
}

void rx(message_t *m, distance_measurement_t *d) {
    uint8_t mm = estimate_distance(d);
    if (mm < nearest) nearest = mm;
}
message_t *tx() { return kilo_uid == 1 ? 0 : &beacon; }

int main() {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
}
