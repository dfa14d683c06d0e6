/* Exercise: forward, left, right, stop, two seconds each with delay(); spins up whenever a motor starts. */
#include <kilolib.h>

void setup() {}

void loop() {
    set_color(RGB(0, 1, 0));
    spinup_motors();
    set_motors(kilo_straight_left, kilo_straight_right);
    delay(2000);

    set_color(RGB(1, 0, 0));
    spinup_motors();
    set_motors(kilo_turn_left, 0);
    delay(2000);

    set_color(RGB(0, 0, 1));
    spinup_motors();
    set_motors(0, kilo_turn_right);
    delay(2000);

    set_color(RGB(0, 0, 0));
    set_motors(0, 0);
    delay(500);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
