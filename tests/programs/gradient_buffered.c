/* A gradient written for the buffered messages: loop empties the receive buffer and keeps one message in the send buffer. */
#include <kilolib.h>
#include <message_buffered.h>

static uint8_t hops = 255;
static message_t m;

static void say() {
    m.type = NORMAL;
    m.data[0] = hops;
    m.crc = message_crc(&m);
    if (txbuffer_size() == 0) txbuffer_push(&m);
}

void setup() {
    if (kilo_uid == 0) hops = 0;
}

void loop() {
    distance_measurement_t dist;
    message_t *in;
    while ((in = rxbuffer_peek(&dist))) {
        if (in->data[0] < 254 && in->data[0] + 1 < hops) hops = in->data[0] + 1;
        rxbuffer_pop();
    }
    if (hops < 255) say();
    set_color(hops == 255 ? RGB(0, 0, 0) : hops % 2 ? RGB(0, 2, 0) : RGB(2, 2, 2));
}

int main() {
    kilo_init();
    kilo_message_buffered();
    kilo_start(setup, loop);
    return 0;
}
