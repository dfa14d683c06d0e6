/* A program for messages without ids, which every robot in sight hears: type 20, a place in 6 + 6 bits, 8 bits of
   heading and 3 bits of the floor's colour, which it shows; the other bytes must count up. Words to single robots
   (type 0) it does not know; answers ARK's question for its id. */
#include "kilolib.h"
uint8_t x = 0, y = 0, heading = 0, floor_colour = 0, known = 0, wrong = 0;

void message_rx(message_t *msg, distance_measurement_t *d) {
    if (msg->type == 20) {
        x = msg->data[0] >> 2;
        y = (msg->data[0] & 3) << 4 | msg->data[1] >> 4;
        heading = (msg->data[1] & 0x0F) << 4 | msg->data[2] >> 4;
        floor_colour = (msg->data[2] >> 1) & 7;
        if (msg->data[4] != (uint8_t)(msg->data[3] + 1) || msg->data[8] != (uint8_t)(msg->data[3] + 5)) wrong = 1;
        known = 1;
    } else if (msg->type == 120) {
        uint16_t id = (uint16_t)msg->data[0] << 8 | msg->data[1];
        set_color(id == kilo_uid ? RGB(0, 0, 3) : RGB(3, 0, 0));
    }
}

void setup() { set_color(RGB(0, 0, 0)); }

void loop() {
    if (wrong) set_color(RGB(3, 3, 3));
    else if (known) set_color(RGB(floor_colour & 1 ? 3 : 0, floor_colour & 2 ? 3 : 0, floor_colour & 4 ? 3 : 0));
    else set_color(RGB(0, 0, 0));
}

int main() {
    kilo_init();
    kilo_message_rx = message_rx;
    kilo_start(setup, loop);
    return 0;
}
