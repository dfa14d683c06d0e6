/* Style: rand() of the robot's C library, whose first numbers are known, one stream for each robot. Green while every number is
   as it must be; also walks by it. */
#include <kilolib.h>
#include <stdlib.h>

static const uint16_t expected[5] = {16807, 15089, 11481, 3114, 14210};
static uint8_t wrong = 0;

void setup() {
    uint8_t i;
    for (i = 0; i < 5; i++)
        if (rand() != expected[i]) wrong = 1;
    if (RAND_MAX != 0x7FFF) wrong = 1;
    srand(1);
    if (rand() != expected[0]) wrong = 1;
    if (rand_soft() != 253 || rand_soft() != 21) wrong = 1;
    srand(kilo_uid + 1);
}

void loop() {
    double u = (double)rand() / ((double)RAND_MAX + 1);
    if (u < 0 || u >= 1) wrong = 1;
    spinup_motors();
    if (u < 0.5) set_motors(kilo_straight_left, kilo_straight_right);
    else if (u < 0.75) set_motors(kilo_turn_left, 0);
    else set_motors(0, kilo_turn_right);
    set_color(wrong ? RGB(3, 0, 0) : RGB(0, 3, 0));
    delay(1000);
}

int main() {
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}
