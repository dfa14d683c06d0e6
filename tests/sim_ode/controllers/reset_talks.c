/* Sends in each tick, and gives up when it is asked for a message before its setup. */
#include "kilolib.h"
#include <assert.h>

static message_t message;
static int ready = 0;

static message_t* tx(void) {
    assert(ready);
    return &message;
}
static void setup(void) {
    ready = 1;
    message.crc = message_crc(&message);
}
static void loop(void) {}
int main(void) {
    kilo_init();
    kilo_tx_period = 0;
    kilo_message_tx = tx;
    kilo_start(setup, loop);
    return 0;
}
