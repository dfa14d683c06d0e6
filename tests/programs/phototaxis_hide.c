/* Away from the light: a running mean instead of many samples in one go, extremes that fade, and turns to the side that a robot
   that seeks light would not take. */
#include <kilolib.h>

static int16_t mean = -1;
static int16_t low = 1023, high = 0;
static uint32_t learn_until = 0, next_fade = 0;
static uint8_t going_left = 2;

static void turn(uint8_t left) {
    if (left == going_left) return;
    going_left = left;
    spinup_motors();
    if (left) set_motors(kilo_turn_left, 0);
    else set_motors(0, kilo_turn_right);
    set_color(left ? RGB(0, 1, 0) : RGB(0, 1, 1));
}

void setup() {
    learn_until = kilo_ticks + 310;
    turn(1);
}

void loop() {
    int16_t light = get_ambientlight();
    if (light == -1) return;
    mean = mean < 0 ? light : (3 * mean + light) / 4;
    if (mean < low) low = mean;
    if (mean > high) high = mean;
    if (kilo_ticks < learn_until) return;
    turn(mean < (low + high) / 2);
    if (kilo_ticks > next_fade) {
        next_fade = kilo_ticks + 31;
        if (high > low + 4) { high--; }
    }
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
