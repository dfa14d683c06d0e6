/* Exercise: the same movements without delay(): a change of motion is remembered and takes effect when kilo_ticks says so. */
#include <kilolib.h>

typedef enum { STOP, FORWARD, LEFT, RIGHT } motion_t;

motion_t current_motion = STOP;
uint32_t last_changed = 0;

void set_motion(motion_t new_motion)
{
    if (current_motion != new_motion) {
        current_motion = new_motion;
        switch (current_motion) {
        case STOP:
            set_motors(0, 0);
            break;
        case FORWARD:
            spinup_motors();
            set_motors(kilo_straight_left, kilo_straight_right);
            break;
        case LEFT:
            spinup_motors();
            set_motors(kilo_turn_left, 0);
            break;
        case RIGHT:
            spinup_motors();
            set_motors(0, kilo_turn_right);
            break;
        }
    }
}

void setup()
{
    last_changed = kilo_ticks;
}

void loop()
{
    if (kilo_ticks > last_changed + 64) {
        last_changed = kilo_ticks;
        set_motion((current_motion + 1) % 4);
    }
}

int main()
{
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
