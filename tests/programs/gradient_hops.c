/* Hop count from robot 0. Values that nobody confirms are forgotten after ten seconds. Colour: hops modulo 6, in the order white
   (the source), red, yellow, green, cyan, blue, magenta; off while unknown. */
#include <kilolib.h>

#define NO_GRADIENT 255
#define FORGET_TICKS 310

uint8_t own_gradient = NO_GRADIENT;
uint8_t received_gradient = 0;
uint8_t new_message = 0;
uint32_t last_confirmed = 0;
message_t message;

void update_message() {
    message.type = NORMAL;
    message.data[0] = own_gradient;
    message.crc = message_crc(&message);
}

void show() {
    static const uint8_t colors[6] = {
        RGB(3, 0, 3), RGB(3, 0, 0), RGB(3, 3, 0), RGB(0, 3, 0), RGB(0, 3, 3), RGB(0, 0, 3)
    };
    if (own_gradient == NO_GRADIENT) set_color(RGB(0, 0, 0));
    else if (own_gradient == 0) set_color(RGB(3, 3, 3));
    else set_color(colors[own_gradient % 6]);
}

void setup() {
    if (kilo_uid == 0) own_gradient = 0;
    update_message();
    show();
}

void loop() {
    if (new_message) {
        new_message = 0;
        if (own_gradient > received_gradient + 1) {
            own_gradient = received_gradient + 1;
            last_confirmed = kilo_ticks;
            update_message();
        } else if (own_gradient == received_gradient + 1) {
            last_confirmed = kilo_ticks;
        }
    }
    if (own_gradient != 0 && own_gradient != NO_GRADIENT && kilo_ticks > last_confirmed + FORGET_TICKS) {
        own_gradient = NO_GRADIENT;
        update_message();
    }
    show();
}

void message_rx(message_t *m, distance_measurement_t *d) {
    received_gradient = m->data[0];
    new_message = 1;
}

message_t *message_tx() {
    return own_gradient == NO_GRADIENT ? NULL : &message;
}

int main() {
    kilo_init();
    kilo_message_rx = message_rx;
    kilo_message_tx = message_tx;
    kilo_start(setup, loop);
    return 0;
}
