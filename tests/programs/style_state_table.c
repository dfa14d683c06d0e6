/* Style: a state machine as a table of function pointers, states that return the next one, callbacks that change at run time. */
#include <kilolib.h>
struct state;
typedef void (*state_fn)(struct state *);
struct state { state_fn next; uint32_t since; int count; };
static void wait_state(struct state *), talk_state(struct state *), done_state(struct state *);
static message_t m;
static uint8_t heard, told;
static message_t *say(void) { return &m; }
static void said(void) { told++; }
static void listen(message_t *in, distance_measurement_t *d) { if (in->type == 3) heard++; }
static void deaf(message_t *in, distance_measurement_t *d) { }
static struct state s = { wait_state, 0, 0 };
static void wait_state(struct state *p) { if (kilo_ticks > p->since + 40) { p->since = kilo_ticks; kilo_message_tx = say; kilo_message_tx_success = said; p->next = talk_state; } }
static void talk_state(struct state *p) {
    kilo_message_rx = listen;
    set_color(RGB(0,0,1));
    if (told >= 5 && heard >= 5) { p->next = done_state; kilo_message_tx = 0; kilo_message_rx = deaf; }
}
static void done_state(struct state *p) { p->count++; set_color(p->count > 2 ? RGB(0,3,0) : RGB(3,0,0)); if (p->count == 200) { kilo_message_tx = say; } }
void setup(void) { m.type = 3; m.crc = message_crc(&m); s.since = kilo_ticks; }
void loop(void) { s.next(&s); }
int main(void) { kilo_init(); kilo_start(setup, loop); return 0; }
