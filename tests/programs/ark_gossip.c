/* An ARK program that also talks: what the arena told one robot (kind 1, a value) spreads by infrared; the largest value wins.
   Overhead messages have type 0, neighbours' have type 10. Green once a value is known. */
#include <kilolib.h>

#define PEER 10

volatile uint16_t known = 0;
volatile uint8_t pending = 0;
message_t interactive_message;

static void remember(uint16_t value) {
    if (value > known) {
        known = value;
        pending = 1;
    }
}

static void on_message(message_t *msg, distance_measurement_t *d) {
    if (msg->type == PEER) {
        remember((uint16_t)msg->data[1] << 8 | msg->data[0]);
        return;
    }
    if (msg->type != 0) return;
    for (int i = 0; i < 9; i += 3) {
        uint16_t id = (uint16_t)msg->data[i] << 2 | msg->data[i + 1] >> 6;
        if (id == kilo_uid && (msg->data[i + 1] >> 2 & 15) == 1)
            remember((uint16_t)(msg->data[i + 1] & 3) << 8 | msg->data[i + 2]);
    }
}

static message_t *on_send() {
    if (!known) return 0;
    interactive_message.type = PEER;
    interactive_message.data[0] = known & 255;
    interactive_message.data[1] = known >> 8;
    interactive_message.crc = message_crc(&interactive_message);
    return &interactive_message;
}

static void setup() {}
static void loop() {
    set_color(known ? RGB(0, 3, 0) : RGB(0, 0, 0));
    pending = 0;
}

int main() {
    kilo_init();
    kilo_message_rx = on_message;
    kilo_message_tx = on_send;
    kilo_start(setup, loop);
    return 0;
}
