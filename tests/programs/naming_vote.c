/* A vote between red and blue: everybody takes over the majority of the last five opinions heard, walking meanwhile. */
#include <kilolib.h>

typedef unsigned char uint8;
#define MEMORY 5

uint8 opinion;
uint8 memory[MEMORY];
uint8 filled = 0, at = 0;
uint32_t next_vote = 0, next_step = 0;
message_t m;

static void say(void) {
    m.type = NORMAL;
    m.data[0] = opinion;
    m.crc = message_crc(&m);
}

void setup(void) {
    opinion = rand_hard() & 1;
    say();
}

void loop(void) {
    if (kilo_ticks > next_step) {
        next_step = kilo_ticks + 40 + rand_hard() % 40;
        spinup_motors();
        if (rand_hard() & 3) set_motors(kilo_straight_left, kilo_straight_right);
        else set_motors(kilo_turn_left, 0);
    }
    if (kilo_ticks > next_vote && filled == MEMORY) {
        uint8 i, ones = 0;
        for (i = 0; i < MEMORY; ++i) ones += memory[i];
        opinion = ones > MEMORY / 2;
        filled = 0;
        next_vote = kilo_ticks + 93;
        say();
    }
    set_color(opinion ? RGB(0, 0, 3) : RGB(3, 0, 0));
}

void rx(message_t *in, distance_measurement_t *d) {
    memory[at++ % MEMORY] = in->data[0];
    if (filled < MEMORY) filled++;
}
message_t *tx(void) { return &m; }

int main(void) {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
