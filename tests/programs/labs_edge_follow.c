/* Exercise: robot 0 stays and talks; the others follow its edge: they read the distance of each message, turn left when too far and
   right when too near, spinning up only when the motion changes. */
#include <kilolib.h>
#define STOP 0
#define FORWARD 1
#define LEFT 2
#define RIGHT 3
#define TOO_CLOSE_DISTANCE 40
#define DESIRED_DISTANCE 60

int current_motion = STOP;
int distance;
int new_message = 0;
message_t message;

void set_motion(int new_motion)
{
    if (current_motion != new_motion)
    {
        current_motion = new_motion;
        if (current_motion == STOP) set_motors(0, 0);
        else if (current_motion == FORWARD) { spinup_motors(); set_motors(kilo_straight_left, kilo_straight_right); }
        else if (current_motion == LEFT) { spinup_motors(); set_motors(kilo_turn_left, 0); }
        else if (current_motion == RIGHT) { spinup_motors(); set_motors(0, kilo_turn_right); }
    }
}

void setup()
{
    message.type = NORMAL;
    message.data[0] = 0;
    message.crc = message_crc(&message);
}

void loop()
{
    if (kilo_uid == 0) { set_color(RGB(3,3,3)); return; }
    if (new_message == 1)
    {
        new_message = 0;
        if (distance < TOO_CLOSE_DISTANCE) { set_color(RGB(0, 3, 0)); set_motion(FORWARD); }
        else if (distance < DESIRED_DISTANCE) { set_color(RGB(3, 0, 0)); set_motion(LEFT); }
        else { set_color(RGB(0, 0, 3)); set_motion(RIGHT); }
    }
}

message_t *message_tx()
{
    if (kilo_uid == 0) return &message;
    return '\0';
}

void message_tx_success() { }

void message_rx(message_t *m, distance_measurement_t *d)
{
    new_message = 1;
    distance = estimate_distance(d);
}

int main()
{
    kilo_init();
    kilo_message_tx = message_tx;
    kilo_message_tx_success = message_tx_success;
    kilo_message_rx = message_rx;
    kilo_start(setup, loop);
    return 0;
}
