/* Never leaves loop, waits by delay only, and sends all the time: in a crowd it backs off very often. */
#include "kilolib.h"

static message_t message;

static message_t* tx(void) {
    return &message;
}
static void setup(void) {
    message.data[0] = kilo_uid;
    message.crc = message_crc(&message);
}
static void loop(void) {
    for (;;) {
        set_color(RGB(0, 0, 3));
        delay(500);
        set_color(RGB(0, 3, 0));
        delay(500);
    }
}
int main(void) {
    kilo_init();
    kilo_tx_period = 0;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
