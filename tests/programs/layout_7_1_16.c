/* A program for messages of 7 bits of id, 1 of kind and 16 of value, as studies of best-of-n send them: kind 1 is the
   quality of an option, kind 0 which option it is. Start parameters come before the run by a message of type 10, one
   24-bit number in each of three groups: the group, not an id, says what it is. Green when the quality is above the
   threshold of the first group, red below; magenta while the threshold is missing; answers ARK's question. */
#include "kilolib.h"
uint32_t threshold = 0;
uint16_t quality = 0, option = 0;
uint8_t known = 0;

void message_rx(message_t *msg, distance_measurement_t *d) {
    uint8_t i;
    if (msg->type == 10) {
        threshold = (uint32_t)msg->data[0] << 16 | (uint32_t)msg->data[1] << 8 | msg->data[2];
    } else if (msg->type == 120) {
        uint16_t id = (uint16_t)msg->data[0] << 8 | msg->data[1];
        set_color(id == kilo_uid ? RGB(0, 0, 3) : RGB(3, 0, 0));
    } else if (msg->type == 0) {
        for (i = 0; i < 3; i++) {
            uint8_t *group = msg->data + 3 * i;
            if (group[0] >> 1 != kilo_uid) continue;
            if (group[0] & 1) {
                quality = (uint16_t)group[1] << 8 | group[2];
                known = 1;
            } else option = (uint16_t)group[1] << 8 | group[2];
        }
    }
}

void setup() { set_color(RGB(0, 0, 0)); }

void loop() {
    if (!known) set_color(RGB(0, 0, 0));
    else if (threshold == 0) set_color(RGB(3, 0, 3));
    else set_color(quality > threshold ? RGB(0, 3, 0) : RGB(3, 0, 0));
}

int main() {
    kilo_init();
    kilo_message_rx = message_rx;
    kilo_start(setup, loop);
    return 0;
}
