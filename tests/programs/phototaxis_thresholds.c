/* Towards the light by thresholds: below 300 turn left, above 600 turn right, between them keep on. */
#include <kilolib.h>

#define THRESHOLD_LO 300
#define THRESHOLD_HI 600

enum { STOP, LEFT, RIGHT, STRAIGHT };

int current_motion = STOP;
int current_light = 0;

void set_motion(int new_motion) {
    if (current_motion == new_motion) return;
    current_motion = new_motion;
    switch (new_motion) {
    case STOP: set_motors(0, 0); break;
    case LEFT: spinup_motors(); set_motors(kilo_turn_left, 0); break;
    case RIGHT: spinup_motors(); set_motors(0, kilo_turn_right); break;
    case STRAIGHT: spinup_motors(); set_motors(kilo_straight_left, kilo_straight_right); break;
    }
}

void sample_light() {
    int i = 0;
    int32_t total = 0;
    while (i < 300) {
        int16_t s = get_ambientlight();
        if (s != -1) {
            total += s;
            i++;
        }
    }
    current_light = total / 300;
}

void setup() {
    set_motion(LEFT);
}

void loop() {
    sample_light();
    if (current_light < THRESHOLD_LO) {
        set_motion(RIGHT);
        set_color(RGB(1, 0, 0));
    } else if (current_light > THRESHOLD_HI) {
        set_motion(LEFT);
        set_color(RGB(0, 1, 0));
    }
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
