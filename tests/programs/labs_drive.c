/* Robot 0 drives straight on with its calibrated duties, everybody else stands still. */
#include <kilolib.h>

void setup() {
    if (kilo_uid == 0) {
        spinup_motors();
        set_motors(kilo_straight_left, kilo_straight_right);
        set_color(RGB(0, 3, 0));
    }
}

void loop() {}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
