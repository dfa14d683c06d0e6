/* Buffered messages: counts what it hears in a second with loops that stall for 1.5 s, so that the buffer has to hold several.
   Green when more than one message was waiting at once, at any time; red when never. */
#include <kilolib.h>
#include <message_buffered.h>

static message_t word;
static uint8_t most = 0;

void setup() {
    word.type = NORMAL;
    word.data[0] = kilo_uid;
    word.crc = message_crc(&word);
}

void loop() {
    distance_measurement_t dist;
    while (txbuffer_size() < 3) txbuffer_push(&word);
    if (rxbuffer_size() > most) most = rxbuffer_size();
    while (rxbuffer_peek(&dist)) rxbuffer_pop();
    set_color(most > 1 ? RGB(0, 3, 0) : RGB(3, 0, 0));
    delay(1500);
}

int main() {
    kilo_init();
    kilo_message_buffered();
    kilo_start(setup, loop);
    return 0;
}
