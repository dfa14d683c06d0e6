/* A gradient from two sources in one record: all values live in a struct, the message is written through a struct pointer, the
   neighbours are kept in a table with ages. Colour: which source is nearer (red 0, blue 1), magenta when equal. */
#include <kilolib.h>
#include <string.h>

#define MAXN 10
#define SOURCES 2

typedef struct {
    uint16_t id;
    uint8_t hops[SOURCES];
    uint8_t distance;
    uint32_t heard;
} neighbor_t;

typedef struct {
    uint16_t id;
    uint8_t hops[SOURCES];
} payload_t;

struct {
    neighbor_t neighbors[MAXN];
    uint8_t n;
    uint8_t hops[SOURCES];
    message_t out;
    uint8_t locked;
} my;

void rx(message_t *m, distance_measurement_t *d)
{
    const payload_t *p = (const payload_t *)m->data;
    uint8_t i;
    for (i = 0; i < my.n; i++)
        if (my.neighbors[i].id == p->id) break;
    if (i == my.n) {
        if (my.n == MAXN) return;
        my.n++;
    }
    my.neighbors[i].id = p->id;
    memcpy(my.neighbors[i].hops, p->hops, SOURCES);
    my.neighbors[i].distance = estimate_distance(d);
    my.neighbors[i].heard = kilo_ticks;
}

message_t *tx()
{
    return my.locked ? 0 : &my.out;
}

void purge()
{
    int8_t i;
    for (i = my.n - 1; i >= 0; i--)
        if (kilo_ticks - my.neighbors[i].heard > 100)
            my.neighbors[i] = my.neighbors[--my.n];
}

void setup()
{
    memset(&my, 0, sizeof my);
    my.hops[0] = my.hops[1] = 200;
}

void loop()
{
    uint8_t s, i;
    purge();
    for (s = 0; s < SOURCES; s++) {
        uint8_t best = 200;
        for (i = 0; i < my.n; i++)
            if (my.neighbors[i].hops[s] < best) best = my.neighbors[i].hops[s];
        my.hops[s] = kilo_uid == s ? 0 : best < 200 ? best + 1 : 200;
    }
    my.locked = 1;
    payload_t *p = (payload_t *)my.out.data;
    p->id = kilo_uid;
    memcpy(p->hops, my.hops, SOURCES);
    my.out.type = NORMAL;
    my.out.crc = message_crc(&my.out);
    my.locked = 0;

    if (my.hops[0] < my.hops[1]) set_color(RGB(3, 0, 0));
    else if (my.hops[0] > my.hops[1]) set_color(RGB(0, 0, 3));
    else set_color(RGB(3, 0, 3));
}

int main()
{
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
