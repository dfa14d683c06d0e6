/* Exercise with a header of the program's own beside it, which has the types and the constants; robot 0 pings, the others answer once. */
#include "parts/ping.h"

static state_t mydata_;
#define MY(x) mydata_.x

static message_t *out(void) { return MY(pending) ? &MY(msg) : NULL; }
static void sent(void) { MY(pending) = 0; ++MY(count); }

static void in(message_t *m, distance_measurement_t *d) {
    (void)d;
    if (m->type != PING && m->type != PONG) return;
    if (kilo_uid == 0) { if (m->type == PONG) MY(heard) = true; return; }
    if (m->type == PING) { MY(heard) = true; fill(&MY(msg), PONG, kilo_uid); MY(pending) = 1; }
}

static void setup(void) {
    if (kilo_uid == 0) { fill(&MY(msg), PING, 0); MY(pending) = 1; }
}

static void loop(void) {
    if (kilo_uid == 0 && !MY(pending)) { fill(&MY(msg), PING, 0); MY(pending) = 1; }
    set_color(MY(heard) ? RGB(0,3,0) : RGB(3,0,0));
}

int main(void) {
    kilo_init();
    kilo_message_rx = in;
    kilo_message_tx = out;
    kilo_message_tx_success = sent;
    kilo_start(setup, loop);
    return 0;
}
