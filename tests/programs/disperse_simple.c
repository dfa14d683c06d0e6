/* Dispersion: who hears anybody within 8 cm walks at random, who hears nobody for two seconds stands still. */
#include <kilolib.h>

#define NEAR_MM 80

volatile uint8_t crowded = 0;
uint32_t last_crowded = 0;
uint32_t next_turn = 0;
message_t message;

void setup() {
    rand_seed(rand_hard());
    message.type = NORMAL;
    message.crc = message_crc(&message);
    last_crowded = kilo_ticks;
}

void loop() {
    if (crowded) {
        crowded = 0;
        last_crowded = kilo_ticks;
    }
    if (kilo_ticks > last_crowded + 64) {
        set_motors(0, 0);
        set_color(RGB(0, 1, 0));
        next_turn = 0;
        return;
    }
    set_color(RGB(1, 0, 0));
    if (kilo_ticks >= next_turn) {
        uint8_t r = rand_soft();
        spinup_motors();
        if (r % 3 != 0) {
            set_motors(kilo_straight_left, kilo_straight_right);
            next_turn = kilo_ticks + 90;
        } else {
            if (r & 64) set_motors(kilo_turn_left, 0);
            else set_motors(0, kilo_turn_right);
            next_turn = kilo_ticks + 20 + r / 4;
        }
    }
}

void rx(message_t *m, distance_measurement_t *d) {
    if (estimate_distance(d) < NEAR_MM) crowded = 1;
}
message_t *tx() { return &message; }

int main() {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
