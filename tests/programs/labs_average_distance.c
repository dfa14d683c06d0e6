/* Exercise: averages the distances of all that it hears in 3 seconds; green when the mean is below 6 cm, blue above, red when
   nobody was heard. */
#include <kilolib.h>

message_t message;
uint16_t sum = 0;
uint8_t count = 0;
uint32_t last_report = 0;

void message_rx(message_t *m, distance_measurement_t *d) {
    if (count < 200) {
        sum += estimate_distance(d);
        count++;
    }
}

message_t *message_tx() { return &message; }

void setup() {
    message.type = NORMAL;
    message.data[0] = kilo_uid & 0xff;
    message.crc = message_crc(&message);
}

void loop() {
    if (kilo_ticks < last_report + 3 * TICKS_PER_SEC) return;
    last_report = kilo_ticks;
    if (count == 0) {
        set_color(RGB(3, 0, 0));
    } else {
        uint16_t average = sum / count;
        set_color(average < 60 ? RGB(0, 3, 0) : RGB(0, 0, 3));
    }
    sum = 0;
    count = 0;
}

int main() {
    kilo_init();
    kilo_message_rx = message_rx;
    kilo_message_tx = message_tx;
    kilo_start(setup, loop);
    return 0;
}
