/* Style: void main, registration before kilo_init, code after kilo_start that never runs. */
#include <kilolib.h>

message_t a_message;
uint8_t heard;

message_t *give() { return &a_message; }
void take(message_t *m, distance_measurement_t *d) { heard = 1; }

void setup() {
    a_message.type = 5;
    a_message.crc = message_crc(&a_message);
}
void loop() { set_color(heard ? RGB(0, 1, 0) : RGB(1, 1, 0)); }

void main(void) {
    kilo_message_tx = give;
    kilo_message_rx = take;
    kilo_init();
    kilo_start(setup, loop);
    set_color(RGB(3, 0, 0));
    while (1) {}
}
