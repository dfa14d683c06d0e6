/* A program for an arena that speaks: unpacks three blocks of 10 + 4 + 10 bits, with ids in a signed int, and compares the filler against
   0x3FF and kilo_uid; random walk as long as nothing was said. */
#include "kilolib.h"
#include <stdlib.h>
typedef enum { false, true } bool;
typedef enum { FORWARD = 0, TURN_LEFT = 1, TURN_RIGHT = 2, STOP = 3 } motion_t;
motion_t current_motion_type = STOP;
unsigned int turning_ticks = 0;
const uint8_t max_turning_ticks = 160;
const uint16_t max_straight_ticks = 320;
uint32_t last_motion_ticks = 0;
int sa_id = 0, sa_type = 0, sa_payload = 0;
bool new_sa_msg = false;
int wrong = 0;

void set_motion(motion_t new_motion_type) {
    if (current_motion_type != new_motion_type) {
        switch (new_motion_type) {
        case FORWARD: spinup_motors(); set_motors(kilo_straight_left, kilo_straight_right); break;
        case TURN_LEFT: spinup_motors(); set_motors(kilo_turn_left, 0); break;
        case TURN_RIGHT: spinup_motors(); set_motors(0, kilo_turn_right); break;
        case STOP:
        default: set_motors(0, 0);
        }
        current_motion_type = new_motion_type;
    }
}

void rx_message(message_t *msg, distance_measurement_t *d) {
    if (msg->type == 0) {
        int id1 = msg->data[0] << 2 | (msg->data[1] >> 6);
        int id2 = msg->data[3] << 2 | (msg->data[4] >> 6);
        int id3 = msg->data[6] << 2 | (msg->data[7] >> 6);
        if (id1 < 0 || id2 < 0 || id3 < 0) wrong = 1;
        if (id1 == (int16_t)kilo_uid) { sa_id = id1; sa_type = msg->data[1] >> 2 & 0x0F; sa_payload = ((msg->data[1] & 0b11) << 8) | (msg->data[2]); new_sa_msg = true; }
        if (id2 == (int16_t)kilo_uid) { sa_id = id2; sa_type = msg->data[4] >> 2 & 0x0F; sa_payload = ((msg->data[4] & 0b11) << 8) | (msg->data[5]); new_sa_msg = true; }
        if (id3 == (int16_t)kilo_uid) { sa_id = id3; sa_type = msg->data[7] >> 2 & 0x0F; sa_payload = ((msg->data[7] & 0b11) << 8) | (msg->data[8]); new_sa_msg = true; }
    } else if (msg->type == 120) {
        int id = (msg->data[0] << 8) | msg->data[1];
        if (id == kilo_uid) set_color(RGB(0, 0, 3)); else set_color(RGB(3, 0, 0));
    }
}

void random_walk() {
    switch (current_motion_type) {
    case TURN_LEFT:
    case TURN_RIGHT:
        if (kilo_ticks > last_motion_ticks + turning_ticks) { last_motion_ticks = kilo_ticks; set_motion(FORWARD); }
        break;
    case FORWARD:
        if (kilo_ticks > last_motion_ticks + max_straight_ticks) {
            last_motion_ticks = kilo_ticks;
            if (rand_soft() % 2) set_motion(TURN_LEFT); else set_motion(TURN_RIGHT);
            turning_ticks = rand_soft() % max_turning_ticks + 1;
        }
        break;
    case STOP:
    default: set_motion(STOP);
    }
}

void setup() {
    rand_seed(rand_hard());
    last_motion_ticks = rand_soft() % max_straight_ticks;
    set_motion(FORWARD);
}

void loop() {
    random_walk();
    if (new_sa_msg) { new_sa_msg = false; set_color(sa_type == 1 ? RGB(0, 3, 0) : RGB(0, 0, 3)); }
    if (wrong) set_color(RGB(3, 0, 0));
}

int main() {
    kilo_init();
    kilo_message_rx = rx_message;
    kilo_start(setup, loop);
    return 0;
}
