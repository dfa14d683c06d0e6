/* Style: messages laid out by structures: packed, bit-fields, unions over the nine bytes, negative coordinates. Green when what comes is
   what was sent. */
#include <kilolib.h>
#include <string.h>
#include <stdbool.h>
typedef struct __attribute__((packed)) { uint16_t id; int16_t x, y; uint8_t state : 3; uint8_t team : 5; uint16_t sum; } report_t;
typedef union { report_t r; uint8_t bytes[9]; struct { unsigned a : 4, b : 12; } bits; } body_t;
_Static_assert(sizeof(report_t) == 9, "nine bytes");
static message_t m;
static bool bad, any;
static message_t *tx(void) {
    body_t b;
    b.r.id = kilo_uid; b.r.x = -100 - (int)kilo_uid; b.r.y = 300; b.r.state = kilo_uid & 7; b.r.team = 21; b.r.sum = b.r.id + b.r.x + b.r.y;
    m.type = 5;
    memcpy(m.data, b.bytes, 9);
    m.crc = message_crc(&m);
    return &m;
}
static void rx(message_t *in, distance_measurement_t *d) {
    const report_t *r = (const report_t *)in->data;
    any = true;
    if (r->x != -100 - (int)r->id || r->y != 300 || r->state != (r->id & 7) || r->team != 21 || r->sum != (uint16_t)(r->id + r->x + r->y)) bad = true;
}
void setup(void) {}
void loop(void) { set_color(bad ? RGB(3, 0, 0) : any ? RGB(0, 3, 0) : RGB(0, 0, 3)); }
int main(void) { kilo_init(); kilo_message_rx = rx; kilo_message_tx = tx; kilo_start(setup, loop); return 0; }
