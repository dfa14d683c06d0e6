/* Orbit in the style of beginners: moves for a moment after each message and stops, all with delay(). Everybody orbits the last
   that spoke, if that was an even robot; even robots stand. */
#include <kilolib.h>

int d = 100;
int fresh = 0;
message_t msg;

void setup() {
    msg.type = NORMAL;
    msg.data[0] = kilo_uid % 2;
    msg.crc = message_crc(&msg);
}

void loop() {
    if (kilo_uid % 2 == 0) {
        set_color(RGB(0, 1, 0));
        return;
    }
    if (fresh == 0) return;
    fresh = 0;
    spinup_motors();
    if (d < 60) {
        set_color(RGB(1, 0, 0));
        set_motors(kilo_turn_left, 0);
    } else {
        set_color(RGB(0, 0, 1));
        set_motors(0, kilo_turn_right);
    }
    delay(300);
    set_motors(0, 0);
    set_color(RGB(0, 0, 0));
}

void heard(message_t *m, distance_measurement_t *how_far) {
    if (m->data[0] == 1) return;
    d = estimate_distance(how_far);
    fresh = 1;
}

message_t *speak() { return &msg; }

int main() {
    kilo_init();
    kilo_message_rx = heard;
    kilo_message_tx = speak;
    kilo_start(setup, loop);
    return 0;
}
