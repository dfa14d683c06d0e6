/* Clocks that agree by averaging: each message carries the sender's phase; at the end of a cycle a third of the mean difference is applied
   to the next one. Flashes red at the end of each cycle of 6 seconds. */
#include <kilolib.h>

#define PERIOD 180
#define BLINK 16

uint32_t reset_time = 0;
int16_t adjustment_sum = 0;
uint8_t adjustment_count = 0;
uint32_t next_period = PERIOD;
message_t message;

void setup() {
    rand_seed(rand_hard());
    next_period = PERIOD / 2 + rand_soft() % (PERIOD / 2);
    message.type = NORMAL;
}

void loop() {
    if (kilo_ticks >= reset_time + next_period) {
        int16_t change = 0;
        if (adjustment_count) change = adjustment_sum / (adjustment_count * 3);
        if (change > PERIOD / 4) change = PERIOD / 4;
        if (change < -PERIOD / 4) change = -PERIOD / 4;
        reset_time = kilo_ticks;
        next_period = PERIOD + change;
        adjustment_sum = 0;
        adjustment_count = 0;
        set_color(RGB(1, 0, 0));
    } else if (kilo_ticks > reset_time + BLINK) {
        set_color(RGB(0, 0, 0));
    }
}

message_t *message_tx() {
    message.data[0] = kilo_ticks - reset_time;
    message.crc = message_crc(&message);
    return &message;
}

void message_rx(message_t *m, distance_measurement_t *d) {
    int16_t mine = kilo_ticks - reset_time;
    int16_t theirs = m->data[0];
    int16_t difference = mine - theirs;
    if (difference > PERIOD / 2) difference -= PERIOD;
    if (difference < -PERIOD / 2) difference += PERIOD;
    if (adjustment_count < 100) {
        adjustment_sum += difference;
        adjustment_count++;
    }
}

int main() {
    kilo_init();
    kilo_message_tx = message_tx;
    kilo_message_rx = message_rx;
    kilo_start(setup, loop);
    return 0;
}
