/* An art piece: a wave of colour that runs through the crowd whenever a robot has been dark for long; long rests after it. */
#include <kilolib.h>

#define REST 12000u

static message_t wave;
static uint8_t hue, left_to_say;
static volatile uint8_t come;
static uint32_t dark_since;

static void rx(message_t *m, distance_measurement_t *d) { come = 1; hue = m->data[0]; }
static message_t *tx(void) { return left_to_say ? &wave : 0; }
static void said(void) { left_to_say--; }

static void setup(void) { dark_since = kilo_ticks + rand_hard(); }

static void loop(void) {
    if (!come && kilo_ticks > dark_since + 400) { come = 1; hue = rand_hard(); }
    if (!come) return;
    wave.type = NORMAL;
    wave.data[0] = hue + 1;
    wave.crc = message_crc(&wave);
    left_to_say = 2;
    set_color(RGB(hue, hue >> 2, ~hue));
    delay(1500);
    set_color(RGB(0, 0, 0));
    delay(REST);
    come = 0;
    dark_since = kilo_ticks;
}

int main(void) {
    kilo_init();
    kilo_message_rx = rx;
    kilo_message_tx = tx;
    kilo_message_tx_success = said;
    kilo_start(setup, loop);
    return 0;
}
