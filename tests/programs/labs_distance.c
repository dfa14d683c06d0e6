/* Exercise in ping-pong: everybody talks; the colour says how far the last speaker was: red to 4 cm, yellow to 5, green to 6,
   cyan to 7, blue to 8, white beyond. */
#include <kilolib.h>

uint8_t new_message = 0;
uint8_t distance = 0;
message_t msg;

void setup() {
    msg.type = NORMAL;
    msg.crc = message_crc(&msg);
}

void loop() {
    if (new_message) {
        new_message = 0;
        if (distance <= 40) set_color(RGB(1, 0, 0));
        else if (distance <= 50) set_color(RGB(1, 1, 0));
        else if (distance <= 60) set_color(RGB(0, 1, 0));
        else if (distance <= 70) set_color(RGB(0, 1, 1));
        else if (distance <= 80) set_color(RGB(0, 0, 1));
        else set_color(RGB(1, 1, 1));
    }
}

message_t *message_tx() { return &msg; }

void message_rx(message_t *m, distance_measurement_t *d) {
    new_message = 1;
    distance = estimate_distance(d);
}

int main() {
    kilo_init();
    kilo_message_tx = message_tx;
    kilo_message_rx = message_rx;
    kilo_start(setup, loop);
    return 0;
}
