/* Exercise: a random walk; rand_hard() seeds rand_soft(), which then chooses one of three movements every two seconds. */
#include <kilolib.h>

uint32_t last_update = 0;

void setup() {
    rand_seed(rand_hard());
}

void loop() {
    if (kilo_ticks > last_update + 60) {
        last_update = kilo_ticks;
        uint8_t choice = rand_soft() % 4;
        spinup_motors();
        if (choice < 2) {
            set_color(RGB(0, 1, 0));
            set_motors(kilo_straight_left, kilo_straight_right);
        } else if (choice == 2) {
            set_color(RGB(1, 0, 0));
            set_motors(kilo_turn_left, 0);
        } else {
            set_color(RGB(0, 0, 1));
            set_motors(0, kilo_turn_right);
        }
    }
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
