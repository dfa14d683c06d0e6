/* Style: writes the calibration variables and its own number, and uses duties given as constants. */
#include <kilolib.h>

uint32_t last = 0;
uint8_t phase = 0;

void setup() {
    kilo_turn_left = 70;
    kilo_turn_right = 70;
    kilo_straight_left = 65;
    kilo_straight_right = 66;
    kilo_uid = kilo_uid + 1000;
}

void loop() {
    if (kilo_ticks < last + 93) return;
    last = kilo_ticks;
    phase++;
    set_motors(0xA0, 0xA0);
    delay(15);
    if (phase & 1) set_motors(kilo_straight_left, kilo_straight_right);
    else set_motors(kilo_turn_left, 0);
    set_color(kilo_uid >= 1000 ? RGB(0, 1, 0) : RGB(1, 0, 0));
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
