/* An ARK program that reads its block with shifts into a struct of bit fields and walks: value is an angle of 1024 steps to turn
   by before it walks on; kind 15 is stop. Random walk while nothing is heard. */
#include <kilolib.h>
#include <stdlib.h>
#include <math.h>

#define PI 3.14159265358979323846
#define MAX_TURNING_TICKS 120

typedef enum { FORWARD = 0, TURN_LEFT = 1, TURN_RIGHT = 2, STOP = 3 } motion_t;

typedef struct {
    uint16_t id : 10;
    uint16_t kind : 4;
    uint16_t value : 10;
} block_t;

motion_t current_motion_type = STOP;
unsigned int turning_ticks = 0;
const uint8_t max_straight_ticks = 160;
uint32_t last_motion_ticks = 0;
volatile uint8_t told = 0;
volatile block_t order;

void set_motion(motion_t new_motion_type) {
    if (current_motion_type != new_motion_type) {
        switch (new_motion_type) {
        case FORWARD: spinup_motors(); set_motors(kilo_straight_left, kilo_straight_right); break;
        case TURN_LEFT: spinup_motors(); set_motors(kilo_turn_left, 0); break;
        case TURN_RIGHT: spinup_motors(); set_motors(0, kilo_turn_right); break;
        case STOP: default: set_motors(0, 0);
        }
        current_motion_type = new_motion_type;
    }
}

double wrap(double angle) {
    while (angle > PI) angle -= 2 * PI;
    while (angle < -PI) angle += 2 * PI;
    return angle;
}

void rx_message(message_t *msg, distance_measurement_t *d) {
    uint8_t i;
    if (msg->type != 0) return;
    for (i = 0; i < 3; i++) {
        uint32_t bits = (uint32_t)msg->data[3 * i] << 16 | (uint16_t)msg->data[3 * i + 1] << 8 | msg->data[3 * i + 2];
        if (bits >> 14 != kilo_uid) continue;
        order.id = bits >> 14;
        order.kind = bits >> 10;
        order.value = bits;
        told = 1;
    }
}

void random_walk() {
    switch (current_motion_type) {
    case TURN_LEFT:
    case TURN_RIGHT:
        if (kilo_ticks > last_motion_ticks + turning_ticks) {
            last_motion_ticks = kilo_ticks;
            set_motion(FORWARD);
        }
        break;
    case FORWARD:
        if (kilo_ticks > last_motion_ticks + max_straight_ticks) {
            last_motion_ticks = kilo_ticks;
            set_motion(rand() % 2 ? TURN_LEFT : TURN_RIGHT);
            turning_ticks = rand() % MAX_TURNING_TICKS + 1;
        }
        break;
    case STOP:
    default:
        set_motion(FORWARD);
    }
}

void setup() {
    uint8_t seed = rand_hard();
    rand_seed(seed);
    seed = rand_hard();
    srand(seed);
    last_motion_ticks = rand() % max_straight_ticks;
    set_color(RGB(0, 0, 3));
}

void loop() {
    if (told) {
        double turn;
        told = 0;
        if (order.kind == 15) {
            set_color(RGB(3, 0, 0));
            set_motion(STOP);
            return;
        }
        turn = wrap(2 * PI * order.value / 1024);
        set_color(RGB(0, 3, 0));
        set_motion(turn > 0 ? TURN_LEFT : TURN_RIGHT);
        turning_ticks = (unsigned int)(fabs(turn) * 180 / PI / 1.2);
        last_motion_ticks = kilo_ticks;
    }
    random_walk();
}

int main() {
    kilo_init();
    kilo_message_rx = rx_message;
    kilo_start(setup, loop);
    return 0;
}
