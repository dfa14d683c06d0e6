/* Dispersion by memory: walks on while the nearest neighbour gets farther, turns when it gets nearer. Neighbours by number in a
   small table; float arithmetic for the mean. */
#include <kilolib.h>
#include <math.h>

#define N 8
typedef struct { uint16_t uid; float mm; uint32_t t; } seen_t;

seen_t seen[N];
float before = 0.0f;
uint32_t due = 0;
message_t hello;

void setup() {
    hello.type = 1;
    hello.data[0] = kilo_uid & 0xFF;
    hello.data[1] = kilo_uid >> 8;
    hello.crc = message_crc(&hello);
    rand_seed(kilo_uid + 1);
    due = kilo_ticks + 20;
}

void rx(message_t *m, distance_measurement_t *d) {
    uint16_t who = m->data[0] | m->data[1] << 8;
    int slot = who % N;
    float mm = (float)estimate_distance(d);
    if (seen[slot].uid == who) seen[slot].mm = 0.5f * seen[slot].mm + 0.5f * mm;
    else seen[slot].mm = mm;
    seen[slot].uid = who;
    seen[slot].t = kilo_ticks;
}
message_t *tx() { return &hello; }

void loop() {
    int i, n = 0;
    float crowd = 0;
    if (kilo_ticks < due) return;
    for (i = 0; i < N; i++)
        if (seen[i].t && kilo_ticks - seen[i].t < 62) {
            crowd += 1.0f / fmaxf(seen[i].mm - 30.0f, 1.0f);
            n++;
        }
    if (n == 0) {
        set_motors(0, 0);
        set_color(RGB(0, 2, 0));
        due = kilo_ticks + 31;
    } else {
        spinup_motors();
        if (crowd <= before) {
            set_motors(kilo_straight_left, kilo_straight_right);
            set_color(RGB(2, 2, 0));
            due = kilo_ticks + 93;
        } else {
            if (rand_soft() < 128) set_motors(kilo_turn_left, 0);
            else set_motors(0, kilo_turn_right);
            set_color(RGB(2, 0, 0));
            due = kilo_ticks + 15 + rand_soft() / 3;
        }
    }
    before = crowd;
}

int main() {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
