/* Orbit: robot 0 is the star and speaks; the others go round it. Nearer than 58 mm they turn away, farther they turn back.
   Colours: star white, planet red while it turns left, blue while it turns right. */
#include <kilolib.h>

#define DESIRED_DISTANCE 58

#define STOP 0
#define FORWARD 1
#define LEFT 2
#define RIGHT 3

int current_motion = STOP;
int distance;
int new_message = 0;
message_t message;

void set_motion(int new_motion)
{
    if (current_motion == new_motion) return;
    current_motion = new_motion;
    if (current_motion == STOP) {
        set_motors(0, 0);
    } else if (current_motion == FORWARD) {
        spinup_motors();
        set_motors(kilo_straight_left, kilo_straight_right);
    } else if (current_motion == LEFT) {
        spinup_motors();
        set_motors(kilo_turn_left, 0);
    } else if (current_motion == RIGHT) {
        spinup_motors();
        set_motors(0, kilo_turn_right);
    }
}

void setup()
{
    message.type = NORMAL;
    message.crc = message_crc(&message);
    if (kilo_uid == 0) set_color(RGB(3, 3, 3));
}

void loop()
{
    if (kilo_uid == 0) return;
    if (new_message == 1) {
        new_message = 0;
        if (distance > DESIRED_DISTANCE) {
            set_color(RGB(3, 0, 0));
            set_motion(LEFT);
        } else {
            set_color(RGB(0, 0, 3));
            set_motion(RIGHT);
        }
    }
}

void message_rx(message_t *m, distance_measurement_t *d)
{
    new_message = 1;
    distance = estimate_distance(d);
}

message_t *message_tx()
{
    return kilo_uid == 0 ? &message : NULL;
}

int main()
{
    kilo_init();
    kilo_message_rx = message_rx;
    kilo_message_tx = message_tx;
    kilo_start(setup, loop);
    return 0;
}
