/* Exercise in talking: robot 0 speaks and flashes magenta, the others listen and flash yellow for each message. */
#include <kilolib.h>

message_t transmit_msg;
uint8_t message_sent = 0;
uint8_t new_message = 0;

void setup() {
    transmit_msg.type = NORMAL;
    transmit_msg.data[0] = 0;
    transmit_msg.crc = message_crc(&transmit_msg);
}

void loop() {
    if (message_sent) {
        message_sent = 0;
        set_color(RGB(1, 0, 1));
        delay(100);
        set_color(RGB(0, 0, 0));
    }
    if (new_message) {
        new_message = 0;
        set_color(RGB(1, 1, 0));
        delay(100);
        set_color(RGB(0, 0, 0));
    }
}

message_t *message_tx() {
    return kilo_uid == 0 ? &transmit_msg : 0;
}

void message_tx_success() {
    message_sent = 1;
}

void message_rx(message_t *msg, distance_measurement_t *dist) {
    new_message = 1;
}

int main() {
    kilo_init();
    kilo_message_tx = message_tx;
    kilo_message_tx_success = message_tx_success;
    kilo_message_rx = message_rx;
    kilo_start(setup, loop);

    return 0;
}
