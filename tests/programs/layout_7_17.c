/* A program for messages of 7 bits of id and 17 of the rest: three levels of 5 bits and 2 bits of heading quadrant.
   Shows which resource is the scarcest: red, green or blue; answers ARK's question for its id. */
#include "kilolib.h"
uint8_t levels[3] = {0, 0, 0};
uint8_t quadrant = 0, known = 0;

void message_rx(message_t *msg, distance_measurement_t *d) {
    int i;
    if (msg->type == 120) {
        uint16_t id = (uint16_t)msg->data[0] << 8 | msg->data[1];
        set_color(id == kilo_uid ? RGB(0, 0, 3) : RGB(3, 0, 0));
        return;
    }
    if (msg->type != 0) return;
    for (i = 0; i < 9; i += 3) {
        uint8_t id = msg->data[i] >> 1;
        if (id != kilo_uid) continue;
        levels[0] = (msg->data[i] & 0x01) << 4 | msg->data[i + 1] >> 4;
        levels[1] = (msg->data[i + 1] & 0x0F) << 1 | msg->data[i + 2] >> 7;
        levels[2] = (msg->data[i + 2] >> 2) & 0x1F;
        quadrant = msg->data[i + 2] & 0x03;
        known = 1;
    }
}

void setup() { set_color(RGB(0, 0, 0)); }

void loop() {
    if (!known) set_color(RGB(0, 0, 0));
    else if (levels[0] <= levels[1] && levels[0] <= levels[2]) set_color(RGB(3, 0, 0));
    else if (levels[1] <= levels[2]) set_color(RGB(0, 3, 0));
    else set_color(RGB(0, 0, 3));
}

int main() {
    kilo_init();
    kilo_message_rx = message_rx;
    kilo_start(setup, loop);
    return 0;
}
