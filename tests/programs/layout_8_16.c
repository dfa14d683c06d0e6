/* A program for messages of 8 bits of id and 16 of the rest, split as 1 bit of kind, 5 of x, 5 of y and 5 of heading:
   green in the eastern half, blue in the western; answers ARK's question for its id. */
#include "kilolib.h"
uint8_t my_x, my_y, my_heading, known = 0;

void read_group(const uint8_t *group) {
    if (group[0] != kilo_uid) return;
    if (group[1] & 0x80) return; /* the other kind */
    my_x = (group[1] >> 2) & 0x1F;
    my_y = (group[1] & 0x03) << 3 | group[2] >> 5;
    my_heading = group[2] & 0x1F;
    known = 1;
}

void message_rx(message_t *msg, distance_measurement_t *d) {
    if (msg->type == 0) {
        read_group(&msg->data[0]);
        read_group(&msg->data[3]);
        read_group(&msg->data[6]);
    } else if (msg->type == 120) {
        uint16_t id = (uint16_t)msg->data[0] << 8 | msg->data[1];
        set_color(id == kilo_uid ? RGB(0, 0, 3) : RGB(3, 0, 0));
    }
}

void setup() { set_color(RGB(0, 0, 0)); }

void loop() {
    if (known) set_color(my_x >= 16 ? RGB(0, 3, 0) : RGB(0, 0, 3));
    else set_color(RGB(0, 0, 0));
}

int main() {
    kilo_init();
    kilo_message_rx = message_rx;
    kilo_start(setup, loop);
    return 0;
}
