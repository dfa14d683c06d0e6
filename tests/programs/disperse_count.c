/* Dispersion: keeps a list of neighbours with the time they were last heard, drives while it has any nearer than 7 cm, with a bounce. */
#include <kilolib.h>
#define MAXN 20
#define FORGET (5 * TICKS_PER_SEC)
typedef struct { uint16_t id; uint8_t dist; uint32_t seen; } neighbor_t;
struct { neighbor_t n[MAXN]; uint8_t count; message_t msg; uint32_t turn_until; uint8_t motion; } my;
static void drive(uint8_t how) { if (how == my.motion) return; my.motion = how; if (how) spinup_motors(); set_motors(how & 1 ? kilo_turn_left : 0, how & 2 ? kilo_turn_right : 0); }
void rx(message_t *m, distance_measurement_t *d) {
    uint16_t id = m->data[0] | m->data[1] << 8;
    uint8_t i;
    for (i = 0; i < my.count && my.n[i].id != id; i++) ;
    if (i == my.count) { if (my.count == MAXN) return; my.count++; }
    my.n[i].id = id; my.n[i].dist = estimate_distance(d); my.n[i].seen = kilo_ticks;
}
message_t *tx(void) { my.msg.type = NORMAL; my.msg.data[0] = kilo_uid; my.msg.data[1] = kilo_uid >> 8; my.msg.crc = message_crc(&my.msg); return &my.msg; }
void setup(void) { rand_seed(kilo_uid * 7 + 3); }
void loop(void) {
    uint8_t i, nearest = 255;
    for (i = 0; i < my.count; ) if (kilo_ticks - my.n[i].seen > FORGET) my.n[i] = my.n[--my.count]; else { if (my.n[i].dist < nearest) nearest = my.n[i].dist; i++; }
    if (kilo_ticks < my.turn_until) return;
    if (nearest < 70) { my.turn_until = kilo_ticks + 16 + rand_soft() % 64; drive(1 + rand_soft() % 3); set_color(RGB(3, 0, 0)); }
    else { drive(0); set_color(RGB(0, 3, 0)); }
}
int main(void) { kilo_init(); kilo_message_rx = rx; kilo_message_tx = tx; kilo_start(setup, loop); return 0; }
